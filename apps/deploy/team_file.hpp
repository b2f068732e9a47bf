#pragma once
// The robots of a team and their boards: what `sinew deploy TEAM.toml` reads.
//
//   [robot.striker]
//   host = "pi@10.0.0.1"
//   file = "striker.toml"          # beside this file, or an absolute path
//   binary = "build/arm64/bin/sinew"    # optional: this robot's program, where boards differ
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

struct TeamBoard {
  std::string name;    // for the lines that are printed, and the folder of its fetched runs
  std::string host;    // as ssh knows it
  std::string file;    // path of the robot file
  std::string binary;  // empty: that of the command line
};

struct TeamFile {
  std::vector<TeamBoard> boards{};  // in the order of their names
  std::vector<rt::Problem> problems{};
};

/// Errors: problems say which: not readable, no TOML, no robot, a host twice, an unknown key, a missing one.
TeamFile load_team_file(const std::string& path);

}  // namespace sinew::app
