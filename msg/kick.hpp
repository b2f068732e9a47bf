#pragma once
// What a robot with legs is asked to do with a ball.
#include "msg/geometry.hpp"

namespace sinew::msg {

enum class BallMotion : std::uint32_t {
  kick_forward = 0,
  kick_outward = 1,  // to the kicking foot's own side
  stop = 2           // a ball that rolls towards the robot
};

inline constexpr ValueName kBallMotionNames[] = {
    {"kick_forward", BallMotion::kick_forward}, {"kick_outward", BallMotion::kick_outward}, {"stop", BallMotion::stop}};

enum class Foot : std::uint32_t { left = 0, right = 1 };

inline constexpr ValueName kFootNames[] = {{"left", Foot::left}, {"right", Foot::right}};

/// One motion at a ball. GaitState answers.
struct KickRequest {
  Time stamp;
  std::uint32_t id = 0;  // any number; the answer has it
  BallMotion motion = BallMotion::kick_forward;
  Foot foot = Foot::left;     // that kicks, or that goes aside to stop the ball
  std::uint32_t in_walk = 0;  // 1: a kick within a step of the walk; 0: from a stand, for which the walk stops
};

/// How far the request is that was taken last.
enum class RequestProgress : std::uint32_t {
  none = 0,
  waits = 1,      // for the stand, or for the step of its foot
  moves = 2,      // the foot is on its way
  done = 3,       // it stands or walks again
  broken_off = 4  // by a fall, a failsafe, or because the robot must not move
};

inline constexpr ValueName kRequestProgressNames[] = {{"none", RequestProgress::none},
                                                      {"waits", RequestProgress::waits},
                                                      {"moves", RequestProgress::moves},
                                                      {"done", RequestProgress::done},
                                                      {"broken_off", RequestProgress::broken_off}};

/// Why a request was not taken.
enum class RequestRefusal : std::uint32_t {
  none = 0,
  not_on_feet = 1,  // it fell, lies, rises, gets down, or must not move
  busy = 2,         // with another request
  failsafe = 3,     // one acts
  unknown = 4       // there is no such motion
};

inline constexpr ValueName kRequestRefusalNames[] = {{"none", RequestRefusal::none},
                                                     {"not_on_feet", RequestRefusal::not_on_feet},
                                                     {"busy", RequestRefusal::busy},
                                                     {"failsafe", RequestRefusal::failsafe},
                                                     {"unknown", RequestRefusal::unknown}};

template <>
struct Description<KickRequest> {
  using M = KickRequest;
  static constexpr std::string_view name = "KickRequest", doc = "One motion at a ball.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::id>("1", "any number; the answer in GaitState has it"),
               enum_field<&M::motion>(kBallMotionNames), enum_field<&M::foot>(kFootNames),
               field<&M::in_walk>("1", "1: a kick within a step; 0: from a stand, for which the walk stops"));
};

}  // namespace sinew::msg
