#include "hal/linux/system_check.hpp"

#include <algorithm>
#include <charconv>
#include <ctime>

#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

using enum CheckState;

constexpr int kHighestPriority = 99;
constexpr int kSysNice = 23, kIpcLock = 14;           // capabilities. Source: capability.h
constexpr std::int64_t kUsualSlack_ns = 50'000;       // the kernel's default
constexpr std::int64_t kUsualRobot_bytes = 64 << 20;  // to be locked, when no robot is named
constexpr const char* kHowToPrivilege =
    "run as root, or give the program the privilege: setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM; or a line in "
    "/etc/security/limits.d: USER - rtprio 99 and USER - memlock unlimited";

/// Soft limit of this process; a very large number for "unlimited".
std::optional<std::int64_t> soft_limit(const SystemFiles& files, std::string_view name) {
  const auto row = files.field("proc/self/limits", name);
  if (!row) return std::nullopt;
  if (row->starts_with("unlimited")) return INT64_MAX;
  std::int64_t value = 0;
  if (std::from_chars(row->data(), row->data() + row->size(), value).ec != std::errc()) return std::nullopt;
  return value;
}

bool has_capability(const SystemFiles& files, int bit) {
  const auto mask = files.field("proc/self/status", "CapEff:");
  std::uint64_t bits = 0;
  if (!mask || std::from_chars(mask->data(), mask->data() + mask->size(), bits, 16).ec != std::errc()) return false;
  return bits >> bit & 1;
}

std::string mib(std::uint64_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; }

int highest_priority(const SystemDemand& demand) {
  int highest = demand.device_priority;
  for (const auto& t : demand.threads) highest = std::max(highest, t.fifo_priority);
  return highest;
}

// ---- the kernel

/// "rt", "full", "lazy", "voluntary", "none"; empty when nothing says so.
std::string preemption_model(const SystemFiles& files) {
  const std::string version = files.text("proc/version").value_or("");
  const auto says = [&](std::string_view word) { return version.find(word) != std::string::npos; };
  if (files.text("sys/kernel/realtime") == "1" || says("PREEMPT_RT") || says("PREEMPT RT")) return "rt";
  // "none voluntary (full) lazy": what is in force now.
  if (const auto now = files.text("sys/kernel/debug/sched/preempt")) {
    const auto open = now->find('('), close = now->find(')');
    if (open != std::string::npos && close != std::string::npos) return now->substr(open + 1, close - open - 1);
  }
  const std::string line = " " + files.text("proc/cmdline").value_or("");
  if (const auto at = line.find(" preempt="); at != std::string::npos && says("PREEMPT_DYNAMIC")) {
    const auto value = at + std::string_view(" preempt=").size();
    return line.substr(value, line.find_first_of(" \n", value) - value);
  }
  for (const auto& [option, model] : {std::pair{"CONFIG_PREEMPT_RT", "rt"},
                                      {"CONFIG_PREEMPT_LAZY", "lazy"},
                                      {"CONFIG_PREEMPT", "full"},
                                      {"CONFIG_PREEMPT_VOLUNTARY", "voluntary"},
                                      {"CONFIG_PREEMPT_NONE", "none"}})
    if (files.kernel_option(option) == "y") return model;
  if (says("PREEMPT_DYNAMIC") || version.empty()) return "";
  return says("PREEMPT") ? "full" : "voluntary";  // which of the last two, no file says; they are much alike
}

SystemCheck preemption(const SystemFiles& files) {
  const std::string model = preemption_model(files);
  if (model == "rt") return {"preemption", ok, "the kernel is PREEMPT_RT", ""};
  if (model.empty())
    return {"preemption", unknown, "the kernel does not say how it is preempted",
            "mount debugfs and look at /sys/kernel/debug/sched/preempt"};
  if (model == "full" || model == "lazy")
    return {"preemption", warning, "the kernel is preemptible (" + model + "), but not PREEMPT_RT",
            "its locks and interrupts can delay a loop by milliseconds now and then: a PREEMPT_RT kernel bounds that"};
  return {
      "preemption", warning, "the kernel is hardly preemptible (" + model + ")",
      "other programs' system calls delay every loop: a PREEMPT_RT kernel, or at least preempt=full on the kernel's "
      "command line"};
}

SystemCheck hres_timers(const SystemFiles& files) {
  const auto verdict = [](bool fine) {
    return fine ? SystemCheck{"hres_timers", ok, "timers have nanosecond resolution", ""}
                : SystemCheck{"hres_timers", problem, "timers fire only at the kernel's tick (1 to 10 ms)",
                              "a kernel with CONFIG_HIGH_RES_TIMERS, without highres=off on its command line"};
  };
  if (files.is_live()) {
    timespec resolution{};
    clock_getres(CLOCK_MONOTONIC, &resolution);
    return verdict(resolution.tv_sec == 0 && resolution.tv_nsec <= 1000);
  }
  if ((" " + files.text("proc/cmdline").value_or("") + " ").find(" highres=off ") != std::string::npos)
    return verdict(false);
  if (const auto active = files.field("proc/timer_list", "  .hres_active    :")) return verdict(*active == "1");
  if (const auto built = files.kernel_option("CONFIG_HIGH_RES_TIMERS")) return verdict(*built == "y");
  return {"hres_timers", unknown, "nothing says what resolution timers have", ""};
}

SystemCheck clock_source(const SystemFiles& files) {
  const auto name = files.text("sys/devices/system/clocksource/clocksource0/current_clocksource");
  if (!name) return {"clock_source", unknown, "the clock source cannot be read", ""};
  for (const char* slow : {"hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit"})
    if (*name == slow)
      return {"clock_source", warning, "the clock is read from " + *name + ": each look costs microseconds",
              "clocksource=tsc on the kernel's command line, if the processor's counter is steady"};
  return {"clock_source", ok, "the clock is read from " + *name, ""};
}

// ---- what this process may do

/// The thread says itself what it could not get.
bool fifo_is_refused(int priority) {
  ThreadOptions options;
  options.name = "doctor";
  options.fifo_priority = priority;
  options.stack_bytes = 16 * 1024;
  const auto thread = system_os().start_thread(options, [] {});
  return !thread || !(*thread)->shortfall().empty();
}

SystemCheck sched_fifo(const SystemFiles& files, const SystemDemand& demand) {
  const int wanted = demand.threads.empty() ? 1 : highest_priority(demand);
  if (wanted == 0) return {"sched_fifo", ok, "the robot asks for no fixed priority", ""};
  const bool capable = has_capability(files, kSysNice);
  const auto limit = soft_limit(files, "Max realtime priority");
  if (!capable && !limit) return {"sched_fifo", unknown, "the limits of this process cannot be read", ""};
  const auto allowed = capable ? kHighestPriority : static_cast<int>(std::min<std::int64_t>(*limit, kHighestPriority));
  if (allowed < wanted) {
    const std::string seen = allowed == 0 ? "this process may not use fixed priorities (SCHED_FIFO)"
                                          : "this process may use fixed priorities up to " + std::to_string(allowed) +
                                                "; the robot asks for " + std::to_string(wanted);
    return {"sched_fifo", problem, seen, kHowToPrivilege};
  }
  if (files.is_live() && fifo_is_refused(std::min(allowed, std::max(wanted, 1))))
    return {"sched_fifo", problem, "this process should be allowed fixed priorities, but the kernel refuses",
            "a control group without real-time budget is the usual cause: give it cpu.rt_runtime_us, or leave it"};
  return {"sched_fifo", ok, "fixed priorities (SCHED_FIFO) up to " + std::to_string(allowed) + " are permitted", ""};
}

/// Real-time budget of the control group of this process (cgroup v1); nothing where groups have none.
std::optional<std::int64_t> group_budget_us(const SystemFiles& files) {
  const std::string groups = "\n" + files.text("proc/self/cgroup").value_or("");
  for (std::size_t at = groups.find(':'); at != std::string::npos; at = groups.find(':', groups.find('\n', at))) {
    const auto colon = groups.find(':', at + 1);
    if (colon == std::string::npos) break;
    const std::string controllers = groups.substr(at + 1, colon - at - 1);
    const std::string path = groups.substr(colon + 1, groups.find('\n', colon) - colon - 1);
    if (("," + controllers + ",").find(",cpu,") != std::string::npos)
      return files.number("sys/fs/cgroup/" + controllers + (path == "/" ? "" : path) + "/cpu.rt_runtime_us");
    if (groups.find('\n', at) == std::string::npos) break;
  }
  return std::nullopt;
}

SystemCheck throttling(const SystemFiles& files) {
  const auto runtime = files.number("proc/sys/kernel/sched_rt_runtime_us");
  const auto period = files.number("proc/sys/kernel/sched_rt_period_us");
  if (group_budget_us(files) == 0)
    return {"throttling", problem, "the control group of this process gives fixed priorities no processor time",
            "write a budget into its cpu.rt_runtime_us, or start outside of the group"};
  if (!runtime || !period || *period <= 0)
    return {"throttling", unknown, "the kernel's real-time throttle cannot be read", ""};
  if (*runtime < 0) return {"throttling", ok, "the kernel's real-time throttle is off", ""};
  const std::int64_t lost_ms = (*period - *runtime) / 1000;
  const std::string seen = "a fixed-priority thread that does not sleep is frozen for " + std::to_string(lost_ms) +
                           " ms of every " + std::to_string(*period / 1000) + " ms";
  if (*runtime * 10 >= *period * 9) return {"throttling", ok, seen, ""};
  return {"throttling", *runtime == 0 ? problem : warning, seen,
          "set kernel.sched_rt_runtime_us to 95 % of kernel.sched_rt_period_us, the kernel's default"};
}

SystemCheck memory_lock(const SystemFiles& files, const SystemDemand& demand) {
  if (has_capability(files, kIpcLock)) return {"memory_lock", ok, "all memory can be locked", ""};
  const auto limit = soft_limit(files, "Max locked memory");
  if (!limit) return {"memory_lock", unknown, "the limits of this process cannot be read", ""};
  if (*limit == INT64_MAX) return {"memory_lock", ok, "all memory can be locked", ""};
  const std::int64_t wanted =
      demand.locked_bytes > 0 ? static_cast<std::int64_t>(demand.locked_bytes) : kUsualRobot_bytes;
  const std::string seen = mib(static_cast<std::uint64_t>(*limit)) + " can be locked";
  if (*limit >= wanted) return {"memory_lock", ok, seen, ""};
  return {"memory_lock", demand.threads.empty() ? warning : problem,
          seen + ", " + mib(static_cast<std::uint64_t>(wanted)) +
              (demand.threads.empty() ? " are what a robot with a camera wants" : " are asked for") +
              ": a page that was taken away stops a loop",
          kHowToPrivilege};
}

SystemCheck timer_slack(const SystemFiles& files) {
  const auto slack = files.number("proc/self/timerslack_ns");
  if (!slack) return {"timer_slack", unknown, "the timer slack cannot be read", ""};
  const std::string seen = "ordinary threads may wake " + std::to_string(*slack / 1000) + " us late";
  if (*slack <= kUsualSlack_ns) return {"timer_slack", ok, seen + "; the robot's own get no slack", ""};
  return {"timer_slack", warning, seen + " on purpose",
          "somebody enlarged the timer slack: leave out TimerSlackNSec= of the service, or start from another shell"};
}

}  // namespace

const char* to_string(CheckState state) {
  switch (state) {
    case ok:
      return "ok";
    case warning:
      return "warning";
    case problem:
      return "problem";
    case unknown:
      return "unknown";
  }
  return "?";
}

std::vector<SystemCheck> check_system(const SystemFiles& files, const SystemDemand& demand) {
  std::vector<SystemCheck> checks{sched_fifo(files, demand), throttling(files),  memory_lock(files, demand),
                                  preemption(files),         hres_timers(files), clock_source(files),
                                  timer_slack(files)};
  check_processors(files, demand, checks);
  check_board(files, demand, checks);
  return checks;
}

}  // namespace sinew::hal
