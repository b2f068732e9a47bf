// How fast this host's time-stamp counter runs, in kHz. A guest in real time reads that counter and measures its speed
// at its start. The result is wrong by a factor of ten if the host takes the processor away meanwhile; so boot.sh
// passes the speed.
#include <x86intrin.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "hal/platform.hpp"

namespace {

using sinew::hal::system_os, sinew::hal::Time;

/// Both clocks at one moment: the pair of reads, out of a hundred, that took the shortest time.
std::pair<Time, std::uint64_t> now() {
  std::pair<Time, std::uint64_t> best;
  std::uint64_t shortest = ~std::uint64_t{0};
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t before = __rdtsc();
    const Time at = system_os().now();
    const std::uint64_t took = __rdtsc() - before;
    if (took < shortest) shortest = took, best = {at, before + took / 2};
  }
  return best;
}

}  // namespace

int main() {
  const auto from = now();
  system_os().sleep_until(system_os().now() + std::chrono::milliseconds(100));
  const auto to = now();
  const std::chrono::duration<double, std::milli> ms = to.first - from.first;
  std::printf("%.0f\n", static_cast<double>(to.second - from.second) / ms.count());
  return 0;
}
