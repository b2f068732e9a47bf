#pragma once
// How a robot plays alone. Frozen: docs/decisions/0040-the-baseline-is-a-copy.md.
#include "behaviour/tree.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/referee.hpp"
#include "soccer/baseline/kick_choice.hpp"
#include "soccer/field.hpp"

namespace sinew::soccer::baseline {

struct PlayOptions {
  WalkLimits walk{};
  KickOptions kicks{};
  double ball_old_s = 4;  // a ball that was not seen for so long is searched
  double search_turn_radps = 0.5;
  double clear_m = 1;          // of a kick-off or free kick of the others
  double near_place_m = 0.02;  // from where it is to stand when it kicks
  double near_place_rad = 0.12;
  double behind_m = 0.12;  // so much before that place it stops to go round the ball
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
  std::uint32_t player = 1;  // its number in the team
  FieldAt self{};
  FieldPoint ball{0, 0};      // by its own eyes
  FieldPoint ball_mps{0, 0};  // over the ground, axes of "robot"
  double ball_age_s = math::kInf;
  bool ball_gone = false;
  FieldPoint ball_at{0, 0};        // frame "field"
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

/// Adds the options: game, play, striker, search.
void add_player(behaviour::Tree<PlayBoard>& tree);

/// The place of a player for its own or the others' kick-off. Frame "field".
FieldAt ready_place(std::uint32_t player, bool own_kick_off, const Field& field);

}  // namespace sinew::soccer::baseline
