#include "apps/robot/doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/robot/board_rules.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot/robot_check.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/linux/can/can_link.hpp"
#include "hal/linux/devices/connectors.hpp"

namespace sinew::app {
namespace {

using hal::CheckState;

std::size_t count(const std::vector<hal::SystemCheck>& checks, CheckState state) {
  return static_cast<std::size_t>(
      std::count_if(checks.begin(), checks.end(), [&](const auto& c) { return c.state == state; }));
}

/// The text of a key; empty: it has none.
std::string text_of(const drivers::DeviceSpec& spec, const char* key) {
  const auto it = spec.keys.find(key);
  const auto* text = it == spec.keys.end() ? nullptr : std::get_if<std::string>(&it->second.value);
  return text ? *text : "";
}

/// Every value that begins with /dev/ names a device file, whatever the driver calls its key.
void add_device(const std::string& name, const drivers::DeviceSpec& spec, hal::SystemDemand& demand) {
  for (const auto& key : spec.keys)
    if (const auto* text = std::get_if<std::string>(&key.second.value); text && text->starts_with("/dev/"))
      demand.nodes.push_back({*text, name});
  if (const std::string root = text_of(spec, "root"); spec.driver == "iio" && (root.empty() || root == "/"))
    demand.iio = true;
  if (spec.driver == "socketcan") {
    const std::string interface = text_of(spec, "address");
    hal::SystemDemand::Can can{interface, name, 0};
    if (const auto it = spec.keys.find("bit_rate"); it != spec.keys.end())
      if (const auto* rate = std::get_if<std::int64_t>(&it->second.value); rate && *rate > 0)
        can.bit_rate = static_cast<std::uint32_t>(*rate);
    if (!interface.empty()) demand.can.push_back(std::move(can));
  }
  if (const auto it = spec.keys.find("priority"); it != spec.keys.end())
    if (const auto* priority = std::get_if<std::int64_t>(&it->second.value); priority && *priority <= 99)
      demand.device_priority = std::max(demand.device_priority, static_cast<int>(*priority));
  for (const auto& joint : spec.joints) add_device(name + ".joint." + joint.name, joint, demand);
}

/// False after the robot file's problems have been printed.
bool demand_of_file(const DoctorOptions& options, const rt::ModuleTypes& types, hal::SystemDemand& demand) {
  const std::string& path = options.robot;
  LoadedRobot loaded = load_robot(path);
  if (!options.board.empty()) loaded.robot.graph.board = options.board;
  auto problems = loaded.problems;
  if (problems.empty()) {
    rt::Graph graph(loaded.robot.graph, types);
    problems = check_robot(loaded.robot, graph, {});
    if (problems.empty()) {
      demand = system_demand(graph, true);
      add_devices(loaded.robot, demand);
      if (!demand.real_board && !loaded.robot.devices.devices.empty())
        std::fprintf(stderr, "note: board = \"%s\": its devices were not checked; --board linux checks them\n",
                     loaded.robot.graph.board.c_str());
    }
  }
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, path).c_str());
  return problems.empty();
}

}  // namespace

hal::SystemDemand system_demand(rt::Graph& graph, bool real_devices) {
  hal::SystemDemand demand;
  for (const auto& thread : graph.threads()) {
    const bool guardian = &thread == &graph.threads().front() && !graph.spec().actuators.empty();
    const bool reads = std::any_of(thread.modules.begin(), thread.modules.end(),
                                   [&](std::uint32_t m) { return graph.modules()[m].driver != nullptr; });
    demand.threads.push_back(
        {thread.spec.name, thread.spec.priority, thread.spec.cpus, real_devices && reads && !guardian});
    demand.locked_bytes += std::uint64_t{thread.spec.stack_kib} * 1024;
  }
  if (graph.make_plan({})) demand.locked_bytes += graph.plan().bytes();
  return demand;
}

void add_devices(const RobotFile& robot, hal::SystemDemand& demand) {
  if (!uses_linux_board(robot.graph)) return;
  demand.real_board = true;
  demand.device_priority = hal::kDeviceWatchPriority;  // no driver asks for more unless its key `priority` says so
  for (const auto& bus : robot.devices.buses) add_device("bus." + bus.name, bus, demand);
  for (const auto& device : robot.devices.devices) {
    if (board_of(robot.graph, device.name) == "linux") add_device("device." + device.name, device, demand);
  }
  if (!robot.parent.watchdog.empty()) demand.nodes.push_back({robot.parent.watchdog, "parent.watchdog"});
  demand.can_facts = [](const std::string& interface) -> std::optional<hal::SystemDemand::CanFacts> {
    const auto link = hal::read_can_link(interface);
    if (!link) return std::nullopt;
    return hal::SystemDemand::CanFacts{link->bit_rate, link->restart_ms, link->state == hal::CanState::bus_off};
  };
}

std::string doctor_text(const std::vector<hal::SystemCheck>& checks) {
  std::string out;
  for (const auto& c : checks) {
    out += fmt::format("{:<8} {:<13} {}\n", hal::to_string(c.state), c.id, c.seen);
    if (!c.advice.empty()) out += fmt::format("{:<22} -> {}\n", "", c.advice);
  }
  const auto problems = count(checks, CheckState::problem), warnings = count(checks, CheckState::warning);
  return out + fmt::format("{} checks: {} problem{}, {} warning{}, {} unknown\n", checks.size(), problems,
                           problems == 1 ? "" : "s", warnings, warnings == 1 ? "" : "s",
                           count(checks, CheckState::unknown));
}

std::string doctor_lines(const std::vector<hal::SystemCheck>& checks) {
  std::string out;
  for (const auto& c : checks)
    if (c.state == CheckState::problem || c.state == CheckState::warning)
      out += fmt::format("{}: {}: {}\n", hal::to_string(c.state), c.id, c.seen);
  return out;
}

std::string doctor_json(const std::vector<hal::SystemCheck>& checks) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& c : checks)
    all.push_back({{"id", c.id}, {"state", hal::to_string(c.state)}, {"seen", c.seen}, {"advice", c.advice}});
  const nlohmann::ordered_json j = {{"problems", count(checks, CheckState::problem)},
                                    {"warnings", count(checks, CheckState::warning)},
                                    {"checks", all}};
  // What came from files of the machine need not be UTF-8.
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

bool ails(const std::vector<hal::SystemCheck>& checks, bool strict) {
  return count(checks, CheckState::problem) > 0 || (strict && count(checks, CheckState::warning) > 0);
}

int doctor_command(const DoctorOptions& options, const rt::ModuleTypes& types) {
  if (!std::filesystem::is_directory(options.root)) {
    std::fprintf(stderr, "sinew: --root %s: a folder with proc/ and sys/ of a machine\n", options.root.c_str());
    return 2;
  }
  hal::SystemDemand demand;
  if (!options.robot.empty() && !demand_of_file(options, types, demand)) return 2;
  const auto checks = hal::check_system(hal::SystemFiles(options.root), demand);
  std::fputs((options.json ? doctor_json(checks) : doctor_text(checks)).c_str(), stdout);
  return ails(checks, options.strict) ? 1 : 0;
}

bool doctor_permits_start(rt::Graph& graph, const RobotFile& robot, bool strict) {
  const std::string& board = graph.spec().board;
  const bool real_devices = board != "sim" && board != "dataset" && board != "none";
  hal::SystemDemand demand = system_demand(graph, real_devices);
  add_devices(robot, demand);
  auto checks = hal::check_system(hal::SystemFiles("/"), demand);
  // Not at a start: checks that opening reports better (a missing device), and checks that do not concern timing.
  std::erase_if(checks, [](const hal::SystemCheck& c) {
    return c.id == "devices" || c.id == "kernel_options" || c.id == "root" || c.id == "clock_sync";
  });
  const std::string lines = doctor_lines(checks);
  std::fputs(lines.c_str(), stderr);
  if (lines.empty()) return true;
  std::fprintf(stderr, "sinew doctor says what to do%s\n",
               strict && ails(checks, true) ? "; --strict: not started" : "");
  return !(strict && ails(checks, true));
}

}  // namespace sinew::app
