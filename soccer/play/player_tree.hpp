#pragma once
// How a player plays: its states and decisions. docs/soccer-play.md has the drawing.
#include "behaviour/tree.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/referee.hpp"
#include "soccer/field.hpp"
#include "soccer/play/kick_choice.hpp"

namespace sinew::soccer {

struct PlayOptions {
  WalkLimits walk{};
  KickOptions kicks{};
  double ball_old_s = 4;  // a ball that was not seen for so long is searched
  double search_turn_radps = 0.5;
  double clear_m = 1;          // of a kick-off or free kick of the others
  double near_place_m = 0.02;  // from where it is to stand when it kicks
  double near_place_rad = 0.12;
  double behind_m = 0.12;        // so much before that place it stops to go round the ball
  double stop_least_mps = 0.25;  // a ball that comes faster is stopped by the goalie
  double goalie_out_m = 1.3;     // a ball that is so near to the goal's middle is cleared by the goalie
  double supporter_behind_m = 1.5;
};

/// What decisions read and actions write. Lengths of the ball: frame "robot"; else "field".
struct PlayBoard {
  const PlayOptions* options = nullptr;
  const Field* field = nullptr;

  // Read.
  double now_s = 0;
  msg::GamePhase phase = msg::GamePhase::playing;
  msg::GameKick kick_of = msg::GameKick::any;
  bool penalised = false, on_feet = false, may_move = false, found = false;
  msg::SoccerRole role = msg::SoccerRole::striker;
  std::uint32_t player = 1;  // its number in the team
  FieldAt self{};
  FieldPoint ball{0, 0};      // by its own eyes
  FieldPoint ball_mps{0, 0};  // over the ground, axes of "robot"
  double ball_age_s = math::kInf;
  bool ball_gone = false;
  FieldPoint ball_at{0, 0};        // frame "field": its own, or else the team's
  bool ball_known = false;         // the latter
  FieldPoint ball_before{0, 0};    // at the last "set"
  std::array<Round, 12> others{};  // frame "robot"
  std::size_t others_n = 0;
  bool kick_done = false, kick_failed = false;

  // Written.
  WalkSpeed walk{};
  bool kicks = false;  // in this step it asks for `ask`
  msg::KickRequest ask{};
  msg::GazeCommand gaze{};

  // Kept.
  ChosenKick chosen{};
};

/// Adds the options of a player: game, play, striker, search, supporter, goalie.
void add_player(behaviour::Tree<PlayBoard>& tree);

/// The place of a player for its own or the others' kick-off. Frame "field".
FieldAt ready_place(std::uint32_t player, bool own_kick_off, const Field& field);
/// Where the goalie stands against a ball, and where the supporter waits.
FieldAt goalie_place(const FieldPoint& ball, const Field& field);
FieldAt supporter_place(const FieldPoint& ball, const Field& field, double behind_m);

}  // namespace sinew::soccer
