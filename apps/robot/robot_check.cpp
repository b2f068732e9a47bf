#include "apps/robot/robot_check.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "apps/robot/board_rules.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot/pace_rules.hpp"
#include "apps/robot/policy_rules.hpp"
#include "apps/robot/record_rules.hpp"
#include "apps/robot/ros2_rules.hpp"
#include "apps/robot/team_rules.hpp"
#include "apps/robot/wiring_rules.hpp"
#include "apps/robot_file/calibration.hpp"

namespace sinew::app {

std::vector<rt::Problem> check_robot(const RobotFile& robot, const rt::Graph& graph, const rt::CheckOptions& how) {
  std::vector<rt::Problem> all = graph.check(how);
  const auto add = [&all](std::vector<rt::Problem> more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  // Virtual time and permission belong to a run, not to the file.
  add(check_boards(graph.spec(), {.virtual_time = false, .real_actuators = true}));
  add(check_linux_devices(robot));
  add(check_recording(robot.record, graph));
  // Relations only between parts that have no problems themselves.
  if (all.empty()) add(check_wiring(robot, graph));
  if (all.empty()) add(check_paces(robot, graph));
  if (all.empty()) add(check_policies(robot, graph));
  if (all.empty()) add(check_team(robot, graph));
  if (all.empty()) add(check_ros2(robot, graph));
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
  return all;
}

rt::CheckOptions check_options(const RobotFile& robot) { return {.virtual_time = robot.graph.board != "linux"}; }

UsedCalibration use_calibration(RobotFile& robot, const rt::ModuleTypes& types) {
  UsedCalibration used{calibration_path(robot), false, {}};
  if (used.file.empty()) return used;
  std::ifstream in(used.file, std::ios::binary);
  if (!in) {
    used.absent = true;
    return used;
  }
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const Calibration calibration = parse_calibration(text, used.file);
  used.problems = apply_calibration(calibration, types, robot);
  if (used.problems.empty())  // its values must be allowed as if they were in the robot file
    for (rt::Problem& p : check_linux_devices(robot))
      if (const int line = calibration.line_of(p.key)) p.line = line, used.problems.push_back(std::move(p));
  return used;
}

}  // namespace sinew::app
