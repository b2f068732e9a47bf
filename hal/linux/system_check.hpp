#pragma once
// Checks that this machine can hold a robot's timing. For `sinew doctor` and every real-time start.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/linux/system_files.hpp"

namespace sinew::hal {

enum class CheckState : std::uint8_t {
  ok,
  warning,  // the robot runs, with less certain timing
  problem,  // something that the robot asks for is missing
  unknown,  // the machine does not say
};
const char* to_string(CheckState state);

/// One finding about the machine, for people: what was seen, and what to do about it (empty when it is ok).
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
    bool reads_devices = false;  // waits for data that an interrupt thread of the kernel delivers
  };
  std::vector<Thread> threads;  // empty: no robot was named
  int device_priority = 0;      // the highest that threads of its devices ask for; 0: none asks
  std::uint64_t locked_bytes = 0;

  /// A file in /dev that a device or bus of the robot file names.
  struct Node {
    std::string path;     // "/dev/i2c-1"
    std::string used_by;  // "device.imu"
  };
  /// A CAN interface of the kernel.
  struct Can {
    std::string interface, used_by;
    std::uint32_t bit_rate = 0;  // in the robot file; 0: not given
  };
  std::vector<Node> nodes{};
  std::vector<Can> can{};
  bool iio = false;         // a sensor behind the kernel's Industrial I/O
  bool real_board = false;  // it has devices of this machine

  /// Facts about a CAN interface that the kernel gives by netlink and not in files.
  struct CanFacts {
    std::uint32_t bit_rate = 0, restart_ms = 0;
    bool bus_off = false;
  };
  std::function<std::optional<CanFacts>(const std::string& interface)> can_facts{};  // none: not known
};

/// All checks, in reading order. If `files` is the live machine, a separate thread also tries a fixed priority.
/// Thread:  any; for a start, not for a loop.
std::vector<SystemCheck> check_system(const SystemFiles& files, const SystemDemand& demand);

/// The part about processors: which are usable, their clocks' speeds, idle states, other programs on the processors of
/// the robot's threads, the interrupt threads.
void check_processors(const SystemFiles& files, const SystemDemand& demand, std::vector<SystemCheck>& checks);

/// The part about a board with devices of its own: their files and CAN interfaces, the kernel's build options, swap,
/// the root file system, the wall clock. Nothing for a robot without real devices.
void check_board(const SystemFiles& files, const SystemDemand& demand, std::vector<SystemCheck>& checks);

}  // namespace sinew::hal
