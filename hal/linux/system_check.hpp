#pragma once
// Does this machine hold what a robot's timing needs? What `sinew doctor` and every real-time start say.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/linux/system_files.hpp"

namespace sinew::hal {

enum class CheckState : std::uint8_t {
  ok,
  warning,  // the robot runs, with less certain timing
  problem,  // something that the robot asks for does not hold
  unknown,  // the machine does not say
};
const char* to_string(CheckState state);

/// One thing about the machine, for people: what was seen, and what to do about it (empty when it is ok).
struct SystemCheck {
  std::string id;
  CheckState state = CheckState::unknown;
  std::string seen;
  std::string advice;
};

/// What a robot asks of its machine.
struct SystemDemand {
  struct Thread {
    std::string name;
    int fifo_priority = 0;       // 0: ordinary
    std::vector<int> cpus;       // empty: any
    bool reads_devices = false;  // waits for what an interrupt thread of the kernel delivers
  };
  std::vector<Thread> threads;  // empty: no robot was named
  std::uint64_t locked_bytes = 0;
};

/// All checks, in the order in which they should be read.
/// Where `files` is the live machine, a fixed priority is also tried by a thread of its own.
/// Thread:  any; for a start, not for a loop.
std::vector<SystemCheck> check_system(const SystemFiles& files, const SystemDemand& demand);

/// The part about processors: those usable, their clocks' speeds, idle states, the interrupt threads that they run.
void check_processors(const SystemFiles& files, const SystemDemand& demand, std::vector<SystemCheck>& checks);

}  // namespace sinew::hal
