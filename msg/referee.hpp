#pragma once
// What the referee of a game tells a robot.
#include "msg/geometry.hpp"

namespace sinew::msg {

enum class GamePhase : std::uint32_t {
  initial = 0,  // nobody moves
  ready = 1,    // robots go to their places
  set = 2,      // and stand there
  playing = 3,
  finished = 4,
};

inline constexpr ValueName kGamePhaseNames[] = {{"initial", GamePhase::initial},
                                                {"ready", GamePhase::ready},
                                                {"set", GamePhase::set},
                                                {"playing", GamePhase::playing},
                                                {"finished", GamePhase::finished}};

/// Why a robot has to stay out of the game.
enum class GamePenalty : std::uint32_t {
  none = 0,
  illegal_position = 1,
  incapable = 2,  // lay too long
  left_field = 3,
  pushing = 4,
  ball_holding = 5,
  picked_up = 6,
  motion_in_set = 7,
  game_stuck = 8,  // it did not play the ball while nobody else could
  substitute = 9,
  sent_off = 10,
  by_hand = 11,  // somebody at the field said so, not the referee
  service = 12,
  other = 13,
};

inline constexpr ValueName kGamePenaltyNames[] = {{"none", GamePenalty::none},
                                                  {"illegal position", GamePenalty::illegal_position},
                                                  {"incapable", GamePenalty::incapable},
                                                  {"left the field", GamePenalty::left_field},
                                                  {"pushing", GamePenalty::pushing},
                                                  {"ball holding", GamePenalty::ball_holding},
                                                  {"picked up", GamePenalty::picked_up},
                                                  {"motion in set", GamePenalty::motion_in_set},
                                                  {"game stuck", GamePenalty::game_stuck},
                                                  {"substitute", GamePenalty::substitute},
                                                  {"sent off", GamePenalty::sent_off},
                                                  {"by hand", GamePenalty::by_hand},
                                                  {"service", GamePenalty::service},
                                                  {"other", GamePenalty::other}};

/// The team that may play the ball.
enum class GameKick : std::uint32_t { any = 0, own = 1, other = 2 };

inline constexpr ValueName kGameKickNames[] = {
    {"any", GameKick::any}, {"own", GameKick::own}, {"other", GameKick::other}};

/// The game as the referee has it, told to one robot. "own" is the robot's team.
struct RefereeState {
  Time stamp;
  double left_s = 0;          // of this half
  double penalty_left_s = 0;  // of the robot's own penalty
  GamePhase phase = GamePhase::initial;
  GamePenalty penalty = GamePenalty::none;  // the robot's own
  GameKick kick = GameKick::any;
  std::uint32_t half = 0;  // 1, 2
  std::uint32_t own_goals = 0, other_goals = 0;
  std::uint32_t team = 0;           // 0 blue, 1 red
  std::uint32_t attacks_right = 0;  // 1: the other goal is at the field's positive x
};

template <>
struct Description<RefereeState> {
  using M = RefereeState;
  static constexpr std::string_view name = "RefereeState", doc = "The game as the referee has it, told to one robot.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::left_s>("s", "of this half"),
               field<&M::penalty_left_s>("s", "of the robot's own penalty"), enum_field<&M::phase>(kGamePhaseNames),
               enum_field<&M::penalty>(kGamePenaltyNames, "the robot's own"),
               enum_field<&M::kick>(kGameKickNames, "the team that may play the ball"), field<&M::half>("1", "1 or 2"),
               field<&M::own_goals>("1"), field<&M::other_goals>("1"), field<&M::team>("1", "0: blue, 1: red"),
               field<&M::attacks_right>("1", "1: the other goal is at the field's positive x"));
};

}  // namespace sinew::msg
