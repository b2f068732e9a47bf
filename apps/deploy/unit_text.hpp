#pragma once
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// The systemd unit of a robot, and where things are on its board.
struct UnitOptions {
  std::string folder;          // of the deployment; the version in force is FOLDER/app
  std::string robot_file;      // its name in there
  std::string data;            // working folder: runs/ and faults/ come there
  std::string user = "sinew";  // under which the robot runs
  std::vector<int> cpus{};     // of the board; empty: not known
  std::vector<std::string>
      groups{};         // of devices, that the board has: an unknown one would keep the unit from starting
  std::string board{};  // instead of the robot file's; empty: the file's
};

/// The arguments of `sinew run` and `doctor` that say so: " --board linux", or nothing.
std::string board_argument(const std::string& board);

/// "sinew-quad.service".
std::string unit_name(const RobotFile& robot);

/// Why these names cannot stand in a unit; empty: they can.
std::string refuse_unit(const UnitOptions& options);

/// The unit's text. A robot with actuators that arms by itself is never started again by itself.
/// Source:  systemd.exec(5), systemd.service(5), systemd.kill(5); docs/porting.md.
std::string unit_text(const RobotFile& robot, const UnitOptions& options);

}  // namespace sinew::app
