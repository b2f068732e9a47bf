#include "apps/deploy/unit_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "hal/linux/system_files.hpp"

namespace sinew::app {
namespace {

bool harmless(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

/// Processors for all other threads: those that the robot file gives to no thread. Empty: all, or not known.
std::vector<int> other_cpus(const RobotFile& robot, const std::vector<int>& board) {
  std::set<int> taken(robot.graph.guardian.cpus.begin(), robot.graph.guardian.cpus.end());
  for (const auto& thread : robot.graph.threads) taken.insert(thread.cpus.begin(), thread.cpus.end());
  std::vector<int> others;
  for (const int cpu : board)
    if (!taken.contains(cpu)) others.push_back(cpu);
  return taken.empty() || others.size() == board.size() ? std::vector<int>{} : others;
}

std::string restart_lines(const RobotFile& robot) {
  const rt::GraphSpec& graph = robot.graph;
  if (!graph.actuators.empty() && graph.guardian.arming == rt::GuardianSpec::Arming::automatic)
    return "# It arms by itself (guardian.arming = \"auto\"): after a fault a person starts it again.\n"
           "Restart=no\n";
  return std::string(graph.actuators.empty()
                         ? "# It moves nothing.\n"
                         : "# Started again it is disarmed, until `sinew arm` (arming = \"manual\").\n") +
         "Restart=on-failure\nRestartSec=2\n";
}

}  // namespace

std::string board_argument(const std::string& board) { return board.empty() ? "" : " --board " + board; }

std::string unit_name(const RobotFile& robot) {
  std::string name = robot.graph.robot;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !harmless(c); }, '_');
  return "sinew-" + name + ".service";
}

std::string refuse_unit(const UnitOptions& options) {
  for (const std::string& path : {options.folder, options.data, options.robot_file, options.user})
    if (path.empty() || !std::all_of(path.begin(), path.end(), [](char c) { return harmless(c) || c == '/'; }))
      return fmt::format("'{}' cannot stand in a unit: only letters, digits and . _ - /", path);
  for (const std::string& path : {options.folder, options.data})
    if (path.front() != '/') return fmt::format("{}: an absolute path is needed in a unit", path);
  return {};
}

std::string unit_text(const RobotFile& robot, const UnitOptions& options) {
  std::string groups;
  for (const auto& group : options.groups) groups += (groups.empty() ? "" : " ") + group;
  const auto cpus = other_cpus(robot, options.cpus);
  const std::string app = options.folder + "/app";
  std::string text = fmt::format(
      "# Written by `sinew deploy`; docs/porting.md says why each line.\n"
      "[Unit]\n"
      "Description=Sinew robot {}\n"
      "After=network.target time-sync.target\n"
      "StartLimitIntervalSec=60\n"
      "StartLimitBurst=5\n"
      "\n[Service]\n"
      "Type=exec\n"
      "ExecStart={}/bin/sinew run {}/{}{} --plain\n"
      "WorkingDirectory={}\n"
      "User={}\n",
      robot.graph.robot, app, app, options.robot_file, board_argument(options.board), options.data, options.user);
  if (!groups.empty()) text += "SupplementaryGroups=" + groups + "\n";
  text +=
      "RuntimeDirectory=sinew\n"
      "RuntimeDirectoryMode=0700\n"
      "Environment=SINEW_RUN_DIR=/run/sinew\n"
      "UMask=0022\n"
      "\n# Fixed priorities and locked memory.\n"
      "LimitRTPRIO=99\n"
      "LimitMEMLOCK=infinity\n"
      "AmbientCapabilities=CAP_SYS_NICE CAP_IPC_LOCK\n"
      "CapabilityBoundingSet=CAP_SYS_NICE CAP_IPC_LOCK\n"
      "OOMScoreAdjust=-900\n";
  if (!cpus.empty())
    text +=
        "# For threads without a processor in the robot file; the other threads choose theirs themselves.\n"
        "CPUAffinity=" +
        hal::to_text(cpus) + "\n";
  text += "\n" + restart_lines(robot) +
          "\n# The parent process gets the signal, ends the run in order and stops the actuators.\n"
          "KillMode=mixed\n"
          "KillSignal=SIGTERM\n"
          "TimeoutStopSec=10\n"
          "# No WatchdogSec: the robot has a parent process and [parent] watchdog for that.\n"
          "\n"
          "NoNewPrivileges=yes\n"
          "ProtectSystem=strict\n"
          "ProtectHome=read-only\n"
          "PrivateTmp=yes\n"
          "ReadWritePaths=" +
          options.data +
          "\n"
          "\n[Install]\n"
          "WantedBy=multi-user.target\n";
  return text;
}

}  // namespace sinew::app
