#pragma once
#include <optional>
#include <string>

#include "rt/module_types.hpp"

namespace sinew::app {

struct DeployOptions {
  std::string host, robot;            // host: may be a team's file (team_file.hpp); then no robot
  std::string folder = "/opt/sinew";  // on the board
  std::string data;                   // on the board: folder of recorded runs; empty: FOLDER/data
  std::string binary;                 // empty: this program
  std::string ssh = "ssh";
  std::string board;           // instead of the robot file's, on the board too; empty: the file's
  std::string user = "sinew";  // of the unit
  bool unit = false, start = false, print_unit = false, rollback = false;
  std::optional<std::string> fetch;  // brings runs back into this folder, and does nothing else
  bool replay = false;               // then executes every run of that folder again
};

/// Brings a robot to its board. Exit code 0: done; 1: failed on the way, and the previous version stays in force unless
/// the new one is complete; 2: could not begin, nothing was sent.
int deploy_command(const DeployOptions& options, const rt::ModuleTypes& types);

/// Brings recorded runs back from a board. Exit codes as above.
int fetch_command(const DeployOptions& options);

/// Executes every recorded run below a folder again (`sinew replay`), one after the other. Exit code 0: each is
/// identical to what the robot did; 1: one is not, or cannot be executed, or there is none.
int replay_runs(const std::string& folder);

/// Whether `host` is the file of a team: TEAM.toml.
bool is_team_file(const std::string& host);
/// The same for each robot of a team, one after the other, also after one that failed; fetched runs go into a folder of
/// the robot's name. Exit code 0: all are done; 1: some are, or failed on the way; 2: nothing was sent to anybody.
int deploy_team(const DeployOptions& options, const rt::ModuleTypes& types);

}  // namespace sinew::app
