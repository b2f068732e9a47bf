#include "apps/robot_file/parent_options.hpp"

#include <algorithm>

namespace sinew::app {

using namespace std::chrono_literals;

hal::Duration shortest_hang(const rt::GraphSpec& graph) {
  hal::Duration lease{};
  for (const auto& a : graph.actuators)
    if (lease.count() == 0 || a.lease < lease) lease = a.lease;
  return 2 * lease;
}

hal::Duration hang_of(const ParentOptions& options, const rt::GraphSpec& graph, double rate) {
  const hal::Duration hang =
      options.hang.count() > 0 ? options.hang : std::max<hal::Duration>(500ms, shortest_hang(graph));
  return hal::Duration{static_cast<std::int64_t>(static_cast<double>(hang.count()) / std::min(rate, 1.0))};
}

}  // namespace sinew::app
