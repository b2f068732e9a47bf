#pragma once
// Contradictions between the sections of a robot file about the same device.
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// `run` refuses the same as `check`, before it opens any device; `robot` is as it runs, with its options.
/// - A module that reads a device (drivers::DeviceReader), an actuator group and a board per device need that device:
///   on the board `linux` as a table [device.NAME], on the board `sim` as a part of the world that is started. A driver
///   of such a table gives what the module reads, on every board.
/// - An actuator group has as many channels as its device has joints. Its limit is no wider than the widest range of
///   the joints, and leaves something of each joint's own range.
/// - Frames of a camera fit into the topic of the module that reads it; larger frames would all be dropped.
/// Graph and devices must have no problems of their own.
std::vector<rt::Problem> check_wiring(const RobotFile& robot, const rt::Graph& graph);

/// Joints on the board `linux` whose own range is narrower than their group's `limit`, one a line. That is no fault:
/// each setpoint is clamped to the joint's own range.
/// Robot files without problems only.
std::vector<std::string> narrower_joints(const RobotFile& robot);

}  // namespace sinew::app
