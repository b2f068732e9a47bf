#pragma once
#include <optional>
#include <string>

#include "rt/module_types.hpp"

namespace sinew::app {

struct DeployOptions {
  std::string host, robot;
  std::string folder = "/opt/sinew";  // on the board
  std::string data;                   // on the board: folder of recorded runs; empty: FOLDER/data
  std::string binary;                 // empty: this program
  std::string ssh = "ssh";
  std::string board;           // instead of the robot file's, on the board too; empty: the file's
  std::string user = "sinew";  // of the unit
  bool unit = false, start = false, print_unit = false, rollback = false;
  std::optional<std::string> fetch;  // brings runs back into this folder, and does nothing else
};

/// Brings a robot to its board. Exit code 0: done; 1: failed on the way, and the previous version stays in force unless
/// the new one is complete; 2: could not begin, nothing was sent.
int deploy_command(const DeployOptions& options, const rt::ModuleTypes& types);

/// Brings recorded runs back from a board. Exit codes as above.
int fetch_command(const DeployOptions& options);

}  // namespace sinew::app
