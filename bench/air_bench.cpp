// What the simulated air costs: 100 robots say 200 bytes ten times a second each, and every mate hears it.
// Beside it the floor: the same bytes copied to each mate's memory, without an order, a loss or a time.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <vector>

#include "hal/platform.hpp"
#include "sim_hil/worlds/air.hpp"

namespace {

using namespace sinew;

constexpr std::size_t kRobots = 100, kBytes = 200;
constexpr int kSeconds = 10, kRounds = 9;

struct Result {
  double us_per_robot_s = 0;  // of processor time, for each robot and simulated second
  std::uint64_t heard = 0;
};

Result air_once(hal::Os& os) {
  plant::AirOptions options;
  options.loss = 0.1;
  options.bits_per_s = 1e9;  // otherwise 100 robots fill it
  plant::Air air(options, kRobots, 1);
  const std::vector<std::uint8_t> bytes(kBytes, 7);
  Result result;
  std::uint64_t sum = 0;
  const hal::Duration before = os.thread_cpu_time();
  for (std::int64_t ms = 0; ms < kSeconds * 1000; ++ms) {
    const hal::Time now{ms * 1'000'000};
    for (std::size_t i = 0; i < kRobots; ++i) {
      while (const msg::Datagram* heard = air.receive(i, now)) sum += heard->data[0], ++result.heard;
      if (ms % 100 == static_cast<std::int64_t>(i)) air.send(i, now, bytes, now);
    }
  }
  result.us_per_robot_s = 1e6 * msg::seconds(os.thread_cpu_time() - before) / (kRobots * kSeconds);
  if (sum != 7 * result.heard) std::printf("bytes are not those that were sent\n");
  return result;
}

double floor_once(hal::Os& os) {
  const std::vector<std::uint8_t> bytes(kBytes, 7);
  std::vector<msg::Datagram> mailbox(kRobots);
  const hal::Duration before = os.thread_cpu_time();
  for (int said = 0; said < kSeconds * 10; ++said)
    for (std::size_t from = 0; from < kRobots; ++from)
      for (std::size_t to = 0; to < kRobots; ++to) {
        if (to == from) continue;
        msg::Datagram& d = mailbox[to];
        d.sender = static_cast<std::uint32_t>(from);
        d.size = kBytes;
        std::memcpy(d.data.data(), bytes.data(), bytes.size());
      }
  return 1e6 * msg::seconds(os.thread_cpu_time() - before) / (kRobots * kSeconds);
}

}  // namespace

int main() {
  hal::Os& os = hal::system_os();
  std::vector<double> air, least, ratio;
  Result last;
  for (int i = 0; i < kRounds; ++i) {
    last = air_once(os);
    air.push_back(last.us_per_robot_s);
    least.push_back(floor_once(os));
    ratio.push_back(air.back() / least.back());
  }
  for (auto* all : {&air, &least, &ratio}) std::ranges::sort(*all);
  std::printf(
      "air of %zu robots, 10 Hz of %zu B each: %.0f us of a processor per robot and second (%.0f to %.0f), "
      "%.0f ns per datagram heard; copies alone %.0f us; ratio %.1f\n",
      kRobots, kBytes, air[kRounds / 2], air.front(), air.back(),
      1e3 * air[kRounds / 2] * kRobots * kSeconds / static_cast<double>(last.heard), least[kRounds / 2],
      ratio[kRounds / 2]);
}
