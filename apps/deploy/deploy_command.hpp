#pragma once
#include <optional>
#include <string>

#include "rt/module_types.hpp"

namespace sinew::app {

struct DeployOptions {
  std::string host, robot;
  std::string folder = "/opt/sinew";  // on the board
  std::string data;                   // there, too: where runs are recorded; empty: FOLDER/data
  std::string binary;                 // empty: this program
  std::string ssh = "ssh";
  std::string board;           // instead of the file's, there too; empty: the file's
  std::string user = "sinew";  // of the unit
  bool unit = false, start = false, print_unit = false, rollback = false;
  std::optional<std::string> fetch;  // brings runs back into this folder, and does nothing else
};

/// Brings a robot to its board. Exit code 0: done; 1: it failed on the way, and the version before stays in force where
/// the new one is not whole; 2: it could not be begun: nothing was sent.
int deploy_command(const DeployOptions& options, const rt::ModuleTypes& types);

/// Brings recorded runs back from a board; likewise.
int fetch_command(const DeployOptions& options);

}  // namespace sinew::app
