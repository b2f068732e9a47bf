#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::app {

/// The options of `sinew match`. A is the first team, B the second one.
struct MatchOptions {
  std::array<std::string, 2> teams;  // paths of the robot files, one for all players of a team
  unsigned robots = 2;               // of each team
  double minutes = 10;               // of both halves together
  std::uint64_t seed = 1;            // of the first match; the others have the ones after it
  std::uint64_t count = 1;           // matches
  std::vector<std::string> set;      // "[WHO/]KEY=VALUE": WHO is a, b, or a player such as blue1
  std::vector<std::string> faults;   // "[WHO/]FAULT", likewise
  std::string camera;                // "320x240"; empty: the files'
  std::string out;                   // folder of the recordings; empty: matches/A-B-SEED
  bool no_record = false;
  bool record_all = false;  // with all steps and topics, also those of the fast loops
  bool no_goal_pictures = false;
  std::vector<double> pixels_s;  // from, until, in seconds of plant time: the pictures of all cameras as files
  bool json = false;
  std::vector<std::string> gamecontroller;  // addresses that hear the referee as RoboCup's game controller

  // Of many matches:
  unsigned jobs = 0;  // at once; 0: one for each processor
  double patience_s = 7200;
  std::string results, shard;
};

/// A is blue in matches with an odd seed, and red in the others.
inline bool a_is_blue(std::uint64_t seed) { return seed % 2 == 1; }

/// The words that decide a match, for `sinew match`: all but those about recordings and many matches.
std::vector<std::string> words_of(const MatchOptions& options, bool with_seed = true);

}  // namespace sinew::app
