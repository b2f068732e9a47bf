#pragma once
// What came of a match.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/match/players.hpp"
#include "apps/sweep/case_result.hpp"
#include "apps/team/team_run.hpp"

namespace sinew::app {

struct PlayerResult {
  Player player;
  std::uint64_t falls = 0, rises = 0, kicks = 0, penalties = 0;
  double walked_m = 0, ball_s = 0, longest_down_s = 0;  // ball_s: so long it was the last one at the ball
  int exit_code = 0;   // of its process: 0 and 1 are those of a run that went to its end
  std::string hash{};  // of all that it published
  std::string recording{};
};

struct Goal {
  double at_s = 0;    // of the world
  unsigned team = 0;  // of MatchOptions::teams
  int player = -1;    // that touched the ball last; -1: none
};

struct MatchResult {
  std::uint64_t seed = 0;
  bool finished = false;                 // both halves were played, and no player's process broke down
  std::string trouble{};                 // why it is not
  std::array<std::uint64_t, 2> goals{};  // by team
  std::vector<Goal> goal{};
  std::vector<PlayerResult> players{};
  std::vector<std::string> log{};  // the referee's
  double plant_s = 0;
  Json plant{};  // the simulator's report
};

/// Errors: `trouble`.
MatchResult match_result(const MatchOptions& options, const TeamEnd& end);

/// Score, goals and a table of the players.
std::string to_text(const MatchOptions& options, const MatchResult& result);
/// As a result of many: measures by team, outcome "A won", "B won", "drawn". The same bytes for the same match.
sweep::CaseResult to_case(const MatchOptions& options, const MatchResult& result);

/// How a team is called in tables: the name of its file.
std::string team_name(const MatchOptions& options, unsigned team);

}  // namespace sinew::app
