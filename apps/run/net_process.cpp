#include "apps/run/net_process.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "apps/command/place.hpp"
#include "hal/linux/devices/net_radio.hpp"

namespace sinew::app {

std::unique_ptr<hal::ChildProcess> start_net(const Prepared& prepared, const RunOptions& options) {
  if ((!prepared.robot.net && !prepared.robot.ros2) || options.virtual_time) return nullptr;
  const std::string& robot = prepared.robot.graph.robot;
  std::string why;
  if (hal::ask_net(robot, std::chrono::milliseconds(500), why)) {
    hal::print_now("net: sinew net of this robot runs already\n");
    return nullptr;
  }
  const std::string program = find_program("sinew-net");
  const auto path = hal::net_socket_path(robot, why);
  if (program.empty()) why = "sinew-net is neither beside this program nor in PATH (Debian: sinew-net)";
  if (program.empty() || !path) {
    hal::print_now(fmt::format("net: {}; the robot runs without DDS\n", why));
    return nullptr;
  }
  hal::ChildOptions child_options;
  child_options.log_path = *path + "-log";
  child_options.hears_terminal = false;  // the run ends it
  auto child = hal::ChildProcess::start({program, prepared.robot.path}, child_options);
  if (!child) {
    hal::print_now(fmt::format("net: {}: {}; the robot runs without DDS\n", program, to_string(child.error().code)));
    return nullptr;
  }
  hal::print_now(
      fmt::format("net: sinew-net, process {}; it says how it is in {}\n", (*child)->pid(), child_options.log_path));
  return std::move(*child);
}

}  // namespace sinew::app
