#pragma once
// What robots of a team know of each other.
#include <array>
#include <cstddef>

#include "msg/geometry.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxMates = 15;

/// A mate's message, as a robot hears it on a topic of all mates ("mates/ball.model"). Its instants (fields of type
/// Time) are on the own clock, right to within `stamp_bound_ns`.
template <class T>
struct FromMate {
  Time stamp;                       // the message's own; never later than `received`
  Time received;                    // when its datagram arrived
  std::int64_t stamp_bound_ns = 0;  // of every instant of the message, either way: the two clocks are known so well
  std::uint32_t robot = 0;          // the mate's number
  std::uint32_t sequence = 0;       // of the topic at the mate
  T message{};
};

namespace detail {

/// The name of FromMate<T>: "NavStateFromMate".
template <class T>
struct FromMateName {
  static constexpr std::string_view kEnd = "FromMate";
  static constexpr std::size_t kSize = Description<T>::name.size() + kEnd.size();
  static constexpr std::array<char, kSize> text = [] {
    std::array<char, kSize> joined{};
    std::size_t at = 0;
    for (const char c : Description<T>::name) joined[at++] = c;
    for (const char c : kEnd) joined[at++] = c;
    return joined;
  }();
};

}  // namespace detail

template <class T>
struct Description<FromMate<T>> {
  using M = FromMate<T>;
  static constexpr std::string_view name{detail::FromMateName<T>::text.data(), detail::FromMateName<T>::kSize};
  static constexpr std::string_view doc = "A mate's message.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns", "the message's own, on the clock of the robot that heard it"),
               field<&M::received>("ns", "when its datagram arrived"),
               field<&M::stamp_bound_ns>("ns", "instants of the message are right to within this"),
               field<&M::robot>("1", "the mate's number"), field<&M::sequence>("1", "of the topic at the mate"),
               field<&M::message>("", "as the mate published it, with instants on the own clock"));
};

/// One mate as this robot hears it. Counts are since the start of this robot.
struct MateState {
  Time heard;                        // arrival of its newest frame; 0: never heard
  Time sent;                         // of that frame, on the mate's clock
  std::int64_t clock_offset_ns = 0;  // own clock minus the mate's, at `heard`
  std::int64_t clock_bound_ns = -1;  // the offset is right to within this; -1: not known yet
  double clock_drift = 0;            // of the offset, seconds per second
  std::uint32_t robot = 0;           // its number; 0: no mate at this place
  std::uint32_t start = 0;           // drawn anew at each start of the mate
  std::uint32_t sequence = 0;        // of its newest frame
  std::uint32_t starts = 0;          // of the mate that were heard
  std::uint32_t frames = 0;          // that came, each once
  std::uint32_t lost = 0;            // that never came, or not yet
  std::uint32_t duplicated = 0, reordered = 0;
  std::uint32_t messages = 0;   // that were published here
  std::uint32_t foreign = 0;    // of a topic that is read here, with another definition of its type: another build
  std::uint32_t unclocked = 0;  // dropped: the mate's clock was not known yet
  std::uint32_t dropped = 0;    // older than one before, without room, or broken
};

/// All mates of a robot.
struct TeamState {
  Time stamp;
  std::uint32_t robot = 0;          // own number
  std::uint32_t start = 0;          // of this robot, as its frames say it
  std::uint32_t sent = 0;           // frames handed to the radio
  std::uint32_t sent_bytes = 0;     // wraps
  std::uint32_t garbage = 0;        // datagrams that are no frames
  std::uint32_t other_teams = 0;    // frames of another team
  std::uint32_t strangers = 0;      // frames of robots of this team that are not among the mates
  std::uint32_t last_stranger = 0;  // the number of the last of them
  std::uint32_t starved = 0;        // messages that waited for the budget
  std::uint32_t mates = 0;          // places of `mate` in use
  std::array<MateState, kMaxMates> mate{};
};

/// Where a robot is in the frame that its team shares. What it sees becomes a place for others through this
/// (control/place.hpp).
struct TeamPose {
  Time stamp;
  Vec3 p_team_m;
  Quat q_team_base;
  /// 6x6, row by row: position (m), then a small rotation (rad) in the team's axes that takes `q_team_base` to the
  /// truth.
  std::array<double, 36> covariance{};
};

template <>
struct Description<TeamPose> {
  using M = TeamPose;
  static constexpr std::string_view name = "TeamPose", doc = "Where a robot is in the frame of its team.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::p_team_m>("m", "team's frame"),
               field<&M::q_team_base>("1", "takes the robot's axes to the team's"),
               field<&M::covariance>("", "6x6 by rows: position (m), then rotation (rad) in the team's axes"));
};

template <>
struct Description<MateState> {
  using M = MateState;
  static constexpr std::string_view name = "MateState", doc = "One mate as a robot hears it.";
  static constexpr auto fields = describe(
      field<&M::heard>("ns", "arrival of its newest frame; 0: never"), field<&M::sent>("ns", "of it, the mate's clock"),
      field<&M::clock_offset_ns>("ns", "own clock minus the mate's"),
      field<&M::clock_bound_ns>("ns", "the offset is right to within this; -1: not known"),
      field<&M::clock_drift>("1", "of the offset"), field<&M::robot>("1", "its number; 0: none"),
      field<&M::start>("1", "drawn anew at each of its starts"), field<&M::sequence>("1", "of its newest frame"),
      field<&M::starts>("1", "of the mate that were heard"), field<&M::frames>("1", "that came"),
      field<&M::lost>("1", "frames that never came, or not yet"), field<&M::duplicated>("1", "frames"),
      field<&M::reordered>("1", "frames"), field<&M::messages>("1", "that were published here"),
      field<&M::foreign>("1", "messages of another build's type"),
      field<&M::unclocked>("1", "dropped before its clock was known"),
      field<&M::dropped>("1", "older than one before, without room, or broken"));
};

template <>
struct Description<TeamState> {
  using M = TeamState;
  static constexpr std::string_view name = "TeamState", doc = "The mates of a robot, as it hears them.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns"), field<&M::robot>("1", "own number"), field<&M::start>("1", "as own frames say it"),
      field<&M::sent>("1", "frames handed to the radio"), field<&M::sent_bytes>("B", "of them; wraps"),
      field<&M::garbage>("1", "datagrams that are no frames"), field<&M::other_teams>("1", "frames of another team"),
      field<&M::strangers>("1", "frames of robots that are not among the mates"),
      field<&M::last_stranger>("1", "the number of the last of them"),
      field<&M::starved>("1", "messages that waited for the budget"), field<&M::mates>("1", "places of mate in use"),
      field<&M::mate>("", "in the order of the robot file"));
};

}  // namespace sinew::msg
