// The part of `sinew doctor` for processors, and for the interrupt threads that share them with the robot's.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>

#include "hal/linux/system_check.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

using enum CheckState;

constexpr const char* kCpus = "sys/devices/system/cpu/";
// A wake-up slower than this would be seen in a loop's lateness, which is some 25 us on small machines.
constexpr std::int64_t kHarmlessWake_us = 10;

bool contains(const std::vector<int>& cpus, int cpu) { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); }

/// "cpu0" ... that the machine has.
std::vector<std::string> cpu_folders(const SystemFiles& files) {
  std::vector<std::string> folders;
  for (const auto& name : files.list(kCpus))
    if (name.size() > 3 && name.starts_with("cpu") && name.find_first_not_of("0123456789", 3) == std::string::npos)
      folders.push_back(name);
  return folders;
}

/// A service's CPUAffinity= is only the start: threads may leave it. So a thread tries, and says what it did not get.
bool can_be_tied_to(const std::vector<int>& cpus) {
  ThreadOptions options;
  options.name = "doctor";
  options.cpus = cpus;
  options.stack_bytes = 16 * 1024;
  const auto thread = system_os().start_thread(options, [] {});
  return thread && (*thread)->shortfall().empty();
}

SystemCheck cpus(const SystemFiles& files, const SystemDemand& demand) {
  const auto allowed = files.field("proc/self/status", "Cpus_allowed_list:");
  if (!allowed) return {"cpus", unknown, "the processors that this process may use cannot be read", ""};
  const auto online = files.text(std::string(kCpus) + "online");
  std::vector<int> usable;
  for (const int cpu : cpu_list(*allowed))
    if (!online || contains(cpu_list(*online), cpu)) usable.push_back(cpu);
  // A thread that asks for isolated processors gets them, though the kernel puts nothing there.
  const auto isolated = cpu_list(files.text(std::string(kCpus) + "isolated").value_or(""));
  const std::string seen = "usable processors: " + to_text(usable);
  std::string missing;
  for (const auto& t : demand.threads) {
    std::vector<int> out_of_reach;
    for (const int cpu : t.cpus)
      if (!contains(usable, cpu) && !(contains(isolated, cpu) && (!online || contains(cpu_list(*online), cpu))))
        out_of_reach.push_back(cpu);
    if (!out_of_reach.empty() && !(files.is_live() && can_be_tied_to(out_of_reach)))
      missing += "; thread " + t.name + " asks for " + to_text(out_of_reach);
  }
  if (missing.empty()) return {"cpus", ok, seen, ""};
  return {"cpus", problem, seen + missing,
          "change `cpus` in the robot file, or start with more processors (taskset, AllowedCPUs=, maxcpus=)"};
}

SystemCheck governor(const SystemFiles& files) {
  std::vector<int> slow;
  std::string name;
  bool any = false;
  for (const auto& cpu : cpu_folders(files)) {
    const auto g = files.text(kCpus + cpu + "/cpufreq/scaling_governor");
    if (!g) continue;
    any = true;
    if (*g == "performance") continue;
    slow.push_back(std::atoi(cpu.c_str() + 3));
    name = *g;
  }
  if (!any) return {"governor", ok, "the processors' speed is not scaled by this kernel", ""};
  if (slow.empty()) return {"governor", ok, "all processors run at full speed (performance)", ""};
  return {"governor", warning, "the speed of processors " + to_text(slow) + " follows their load (" + name + ")",
          "a loop that mostly sleeps then runs slowly: cpupower frequency-set -g performance"};
}

SystemCheck idle_states(const SystemFiles& files) {
  std::int64_t deepest_us = -1;
  std::string name;
  for (const auto& cpu : cpu_folders(files)) {
    const std::string folder = kCpus + cpu + "/cpuidle";
    for (const auto& state : files.list(folder)) {
      const std::string path = folder + "/" + state + "/";
      const auto latency = files.number(path + "latency");
      if (!latency || files.number(path + "disable").value_or(0) != 0 || *latency <= deepest_us) continue;
      deepest_us = *latency;
      name = files.text(path + "name").value_or(state);
    }
  }
  if (deepest_us < 0) return {"idle_states", ok, "no idle states are known to this kernel", ""};
  const std::string seen = "waking a processor takes up to " + std::to_string(deepest_us) + " us (" + name + ")";
  if (deepest_us <= kHarmlessWake_us) return {"idle_states", ok, seen, ""};
  if (files.writable("dev/cpu_dma_latency"))
    return {"idle_states", ok, seen + "; a run keeps them awake by /dev/cpu_dma_latency", ""};
  return {"idle_states", warning, seen + ", and /dev/cpu_dma_latency cannot be opened to prevent it",
          "run as root, or permit that file by a udev rule; or switch deep states off: cpupower idle-set -D " +
              std::to_string(kHarmlessWake_us)};
}

/// Processors that threads of fixed priority, the guardian's too, are tied to.
std::vector<int> tied_cpus(const SystemDemand& demand) {
  std::vector<int> tied;
  for (const auto& t : demand.threads)
    if (t.fifo_priority > 0)
      for (const int cpu : t.cpus)
        if (!contains(tied, cpu)) tied.push_back(cpu);
  std::sort(tied.begin(), tied.end());
  return tied;
}

SystemCheck isolation(const SystemFiles& files, const SystemDemand& demand) {
  const auto tied = tied_cpus(demand);
  if (tied.empty()) return {"isolation", ok, "no thread of a fixed priority is tied to processors", ""};
  const auto isolated = cpu_list(files.text(std::string(kCpus) + "isolated").value_or(""));
  const auto tickless = cpu_list(files.text(std::string(kCpus) + "nohz_full").value_or(""));
  std::vector<int> shared, ticking;
  for (const int cpu : tied) {
    if (!contains(isolated, cpu)) shared.push_back(cpu);
    if (!contains(tickless, cpu)) ticking.push_back(cpu);
  }
  const std::string seen = "threads of fixed priorities are tied to processors " + to_text(tied);
  if (shared.empty())
    return {"isolation", ok, seen + ", which are isolated" + (ticking.empty() ? " and without a tick" : ""), ""};
  return {"isolation", warning, seen + "; on " + to_text(shared) + " everything else runs, too",
          "on the kernel's command line: isolcpus=" + to_text(tied) + " nohz_full=" + to_text(tied) +
              " rcu_nocbs=" + to_text(tied) + " irqaffinity=(the others)"};
}

// ---- interrupts

struct IrqThread {
  std::string pid, device;
  int priority = 0;
};

/// True for a device that robots use: words as they appear in names ("can0", "fe205000.i2c", "spi0.0").
bool serves_a_robots_device(std::string_view device) {
  for (const std::string_view word : {"can", "mcp251", "i2c", "spi", "csi", "unicam", "camera", "imx", "uart", "tty",
                                      "serial", "gpio", "usb", "xhci", "ehci", "dwc"}) {
    for (auto at = device.find(word); at != std::string_view::npos; at = device.find(word, at + 1))
      if (at == 0 || !std::isalpha(static_cast<unsigned char>(device[at - 1]))) return true;
  }
  return false;
}

std::vector<IrqThread> irq_threads(const SystemFiles& files) {
  std::vector<IrqThread> threads;
  for (const auto& pid : files.list("proc")) {
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto comm = files.text("proc/" + pid + "/comm");
    if (!comm || !comm->starts_with("irq/")) continue;
    const auto dash = comm->find('-');
    const auto stat = files.text("proc/" + pid + "/stat");
    if (dash == std::string::npos || !stat) continue;
    // Field 40 is the real-time priority; the second is a name in brackets, which may hold blanks. Source: proc(5)
    std::istringstream fields(stat->substr(std::min(stat->size(), stat->rfind(')') + 1)));
    std::string field;
    for (int i = 3; i <= 40; ++i) fields >> field;
    if (fields) threads.push_back({pid, comm->substr(dash + 1), std::atoi(field.c_str())});
  }
  return threads;
}

/// The highest of the threads that wait for devices and are not below `irq`; null: none.
const SystemDemand::Thread* starving(const SystemDemand& demand, const IrqThread& irq) {
  const SystemDemand::Thread* highest = nullptr;
  for (const auto& t : demand.threads)
    if (t.reads_devices && t.fifo_priority > 0 && t.fifo_priority >= irq.priority &&
        (!highest || t.fifo_priority > highest->fifo_priority))
      highest = &t;
  return highest;
}

SystemCheck irq_priorities(const SystemFiles& files, const SystemDemand& demand) {
  std::string seen, starved, how;
  for (const auto& irq : irq_threads(files)) {
    if (!serves_a_robots_device(irq.device)) continue;
    const std::string priority = std::to_string(irq.priority);
    seen += (seen.empty() ? "" : ", ") + irq.device + " at " + priority;
    const auto* thread = starving(demand, irq);
    if (!thread) continue;
    starved += "; thread " + thread->name + " (" + std::to_string(thread->fifo_priority) + ") is not below " +
               irq.device + " (" + priority + ")";
    how += (how.empty() ? "" : "; ") + std::string("chrt -f -p ") +
           std::to_string(std::min(99, thread->fifo_priority + 1)) + " " + irq.pid;
  }
  if (seen.empty()) return {"irq_threads", ok, "no interrupt threads of devices that robots hang on", ""};
  seen = "interrupt threads: " + seen;
  if (starved.empty()) return {"irq_threads", ok, seen, ""};
  return {"irq_threads", problem, seen + starved,
          "a thread that is not below the interrupt thread of its own device keeps it from delivering: " + how};
}

/// The handlers of this interrupt: the folders in its own folder.
std::string handlers(const SystemFiles& files, const std::string& irq) {
  std::string names;
  for (const auto& entry : files.list("proc/irq/" + irq))
    if (files.is_folder("proc/irq/" + irq + "/" + entry)) names += (names.empty() ? "" : ", ") + entry;
  return names;
}

SystemCheck irq_affinity(const SystemFiles& files, const SystemDemand& demand) {
  const auto tied = tied_cpus(demand);
  std::string disturbing, how;
  for (const auto& irq : files.list("proc/irq")) {
    if (tied.empty() || irq.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string folder = "proc/irq/" + irq + "/";
    auto where = files.text(folder + "effective_affinity_list");
    if (!where || where->empty()) where = files.text(folder + "smp_affinity_list");
    const auto cpus = cpu_list(where.value_or(""));
    const bool there = std::any_of(cpus.begin(), cpus.end(), [&](int cpu) { return contains(tied, cpu); });
    const std::string who = there ? handlers(files, irq) : "";
    if (who.empty() || serves_a_robots_device(who)) continue;
    disturbing += (disturbing.empty() ? "" : "; ") + irq + " (" + who + ") on " + to_text(cpus);
    how += (how.empty() ? "" : " ") + irq;
  }
  if (disturbing.empty()) return {"irq_affinity", ok, "no foreign interrupt comes to the robot's processors", ""};
  return {
      "irq_affinity", warning, "interrupts of others come to processors of the robot's threads: " + disturbing,
      "irqaffinity= on the kernel's command line, or write other processors into /proc/irq/N/smp_affinity_list (N: " +
          how + ")"};
}

}  // namespace

void check_processors(const SystemFiles& files, const SystemDemand& demand, std::vector<SystemCheck>& checks) {
  checks.push_back(cpus(files, demand));
  checks.push_back(governor(files));
  checks.push_back(idle_states(files));
  checks.push_back(isolation(files, demand));
  checks.push_back(irq_affinity(files, demand));
  checks.push_back(irq_priorities(files, demand));
}

}  // namespace sinew::hal
