#pragma once
#include <optional>
#include <string>

#include "apps/match/match_result.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// A match that was played, and what it left.
struct PlayedMatch {
  MatchResult result{};
  std::string folder{};  // of its recordings; empty: not recorded
  std::uint64_t recorded_bytes = 0;
  double wall_s = 0;
};

/// Plays one match in virtual time: writes the players' robot files, runs them in one world, and leaves in the folder
/// of `options` a recording of each player, the scenes of all pictures (scenes.mcap), result.json and pictures of
/// goals. Nothing, after saying why: it could not begin, or was interrupted.
std::optional<PlayedMatch> play_match(const MatchOptions& options, const rt::ModuleTypes& types);

/// Executes all recorded steps of all players of a recorded match again, with pictures drawn again from its scenes.
/// Exit code: 0: all are the same; 1: not; 2: there is no such match.
int replay_match(const std::string& folder, bool json);

}  // namespace sinew::app
