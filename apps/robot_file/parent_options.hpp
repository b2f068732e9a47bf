#pragma once
#include <string>

#include "hal/os.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

/// The robot file's [parent].
struct ParentOptions {
  hal::Duration hang{};    // no commit of the guardian for so long: the runtime hangs; 0: hang_of()
  std::string watchdog{};  // "/dev/watchdog"; empty: none
  hal::Duration watchdog_timeout = std::chrono::seconds(5);
  std::string save_to = "faults";  // folder in which each fault gets a folder of its own
};

/// The least `hang`: two of the smallest lease, since without commands the guardian commits twice a lease.
hal::Duration shortest_hang(const rt::GraphSpec& graph);
/// The robot file's `hang`, or else the longer one of 500 ms and shortest_hang(). In time of this machine: longer if
/// the robot's clock runs slower (`rate` below 1).
hal::Duration hang_of(const ParentOptions& options, const rt::GraphSpec& graph, double rate);

}  // namespace sinew::app
