#pragma once
// What the sections of a robot file say of the same device, and cannot all be true.
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// What `check` refuses here, `run` does, too, before any device is opened; `robot` is as it runs, with its options.
/// - A module that reads a device (drivers::DeviceReader), an actuator group and a board per device have one; on the
///   board `linux` that is a table [device.NAME], and wherever that stands its driver gives what the module reads; on
///   the board `sim` a part of the world that is started.
/// - An actuator group has as many channels as its device has joints, no wider limit than the widest of them, and one
/// that
///   leaves something of each joint's own range.
/// - Frames of a camera fit into the topic of the module that reads it: every one would be dropped.
/// Graph and devices without problems of their own.
std::vector<rt::Problem> check_wiring(const RobotFile& robot, const rt::Graph& graph);

/// Joints whose own range is narrower than their group's `limit`, on the board `linux`, one a line: no fault, as
/// each is pulled in to its own.
/// Robot files without problems only.
std::vector<std::string> narrower_joints(const RobotFile& robot);

}  // namespace sinew::app
