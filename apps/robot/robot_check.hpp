#pragma once
// All checks of a robot, in one place for check, run, doctor and deploy.
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// All problems that show without opening anything: of the graph, boards, devices and buses, recording, and of their
/// relations (apps/robot/wiring_rules.hpp). `graph` is that of `robot`. In the order of the lines.
std::vector<rt::Problem> check_robot(const RobotFile& robot, const rt::Graph& graph, const rt::CheckOptions& how);

/// Checks for a file whose kind of run is not known. Only virtual time needs execution times, and real devices never
/// run in virtual time.
rt::CheckOptions check_options(const RobotFile& robot);

/// The result of reading the robot's calibration file.
struct UsedCalibration {
  std::string file;  // empty: the robot names none
  bool absent = false;
  std::vector<rt::Problem> problems;  // of that file: its form, and values that the robot does not allow
};
/// Reads the file, if it exists, and replaces the robot file's values by its values.
UsedCalibration use_calibration(RobotFile& robot, const rt::ModuleTypes& types);

}  // namespace sinew::app
