#pragma once
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// The systemd unit of a robot, and its folders on the board.
struct UnitOptions {
  std::string folder;          // of the deployment; the version in force is FOLDER/app
  std::string robot_file;      // its name in that folder
  std::string data;            // working folder, which gets runs/ and faults/
  std::string user = "sinew";  // under which the robot runs
  std::vector<int> cpus{};     // of the board; empty: not known
  std::vector<std::string>
      groups{};         // groups of devices that the board has: a unit with an unknown group does not start
  std::string board{};  // instead of the robot file's; empty: the file's
};

/// The arguments of `sinew run` and `doctor` that choose the board: " --board linux", or nothing.
std::string board_argument(const std::string& board);

/// "sinew-quad.service".
std::string unit_name(const RobotFile& robot);

/// Why a unit cannot have these names; empty: it can.
std::string refuse_unit(const UnitOptions& options);

/// The unit's text. A robot with actuators and automatic arming is never restarted automatically.
/// Source:  systemd.exec(5), systemd.service(5), systemd.kill(5); docs/porting.md.
std::string unit_text(const RobotFile& robot, const UnitOptions& options);

}  // namespace sinew::app
