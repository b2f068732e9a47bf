#pragma once
// `sinew doctor`: what on this machine breaks a robot's timing, and what to do about it.
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "hal/linux/system_check.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

struct DoctorOptions {
  std::string robot;       // robot file; empty: the machine alone
  std::string board;       // instead of the robot file's
  std::string root = "/";  // root of the machine's files, or of a copy of another machine's
  bool json = false;
  bool strict = false;  // warnings count as problems
};

/// Exit code 0: fine; 1: a problem (with `strict` also a warning); 2: the robot file or the root cannot be used.
int doctor_command(const DoctorOptions& options, const rt::ModuleTypes& types);

/// What a checked graph needs from its machine. `real_devices`: drivers wait for interrupts, not for a simulator.
hal::SystemDemand system_demand(rt::Graph& graph, bool real_devices);

/// Adds what the robot's devices need: files in /dev, CAN interfaces, priorities of their threads. Nothing without a
/// device on the board `linux`.
void add_devices(const RobotFile& robot, hal::SystemDemand& demand);

/// One block a check; short: one line for each warning and problem, nothing for the rest.
std::string doctor_text(const std::vector<hal::SystemCheck>& checks);
std::string doctor_lines(const std::vector<hal::SystemCheck>& checks);
std::string doctor_json(const std::vector<hal::SystemCheck>& checks);

/// Is there a problem, or with `strict` a warning?
bool ails(const std::vector<hal::SystemCheck>& checks, bool strict);

/// At a start in real time: prints warnings and problems on standard error. False when `strict` forbids to start.
bool doctor_permits_start(rt::Graph& graph, const RobotFile& robot, bool strict);

}  // namespace sinew::app
