#pragma once
// The one list of what may be wrong with a robot: check, run, doctor and deploy go by it.
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// Everything that can be said without opening anything: graph, boards, devices and buses, recording, and what they
/// mean to each other (apps/robot/wiring_rules.hpp). `graph` is that of `robot`. In the order of the lines.
std::vector<rt::Problem> check_robot(const RobotFile& robot, const rt::Graph& graph, const rt::CheckOptions& how);

/// What a file is checked for when nobody says how it will run: real devices never run in virtual time, which alone
/// needs execution times.
rt::CheckOptions check_options(const RobotFile& robot);

/// What became of the robot's calibration file.
struct UsedCalibration {
  std::string file;  // empty: the robot names none
  bool absent = false;
  std::vector<rt::Problem> problems;  // of that file: of form, and of what the robot does not allow
};
/// Reads it, if it is there, and puts its values in place of those of the robot file.
UsedCalibration use_calibration(RobotFile& robot, const rt::ModuleTypes& types);

}  // namespace sinew::app
