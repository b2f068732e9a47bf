// What the time line costs: an event, a zone that a listener asks for, and a zone that nobody asks for.
// `timeline_bench --count N` runs N steps with three zones that nobody asks for, and N steps without, for callgrind.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "hal/platform.hpp"
#include "rt/exec/timeline.hpp"
#include "rt/zone.hpp"

namespace sinew::bench {
namespace {

[[gnu::noinline]] void bare_step(const rt::Step& step, volatile std::uint32_t& sink) {
  sink = sink + step.number;
  sink = sink + 1;
  sink = sink + 2;
}

[[gnu::noinline]] void zoned_step(const rt::Step& step, volatile std::uint32_t& sink) {
  {
    const rt::Zone zone(step, "first");
    sink = sink + step.number;
  }
  {
    const rt::Zone zone(step, "second");
    sink = sink + 1;
  }
  const rt::Zone zone(step, "third");
  sink = sink + 2;
}

template <class Body>
double ns_each(hal::Os& os, int n, Body&& body) {
  const hal::Time begin = os.now();
  for (int i = 0; i < n; ++i) body(i);
  return static_cast<double>((os.now() - begin).count()) / n;
}

void measure() {
  hal::Os& os = hal::system_os();
  rt::TimelineRing ring(8192, rt::Time{0});
  rt::RingZones log(ring, os, 0);
  math::Random random(1, 2, 3);
  rt::Step step{rt::Time{}, rt::Duration{1}, false, 3, random};
  volatile std::uint32_t sink = 0;
  std::printf("%10s %10s %16s %16s %16s   (ns)\n", "loop", "event", "step, no zones", "3 unasked", "3 asked");
  for (int pair = 0; pair < 5; ++pair) {
    const double loop = ns_each(os, 10'000'000, [&](int i) { sink = static_cast<std::uint32_t>(i); });
    const double event = ns_each(
        os, 10'000'000, [&](int i) { ring.add(rt::TimelineEvent::Kind::step, rt::Time{i}, rt::Duration{i}, 3); });
    step.zones = nullptr;
    const double bare = ns_each(os, 10'000'000, [&](int) { bare_step(step, sink); });
    const double unasked = ns_each(os, 10'000'000, [&](int) { zoned_step(step, sink); });
    step.zones = &log;
    const double asked = ns_each(os, 300'000, [&](int) { zoned_step(step, sink); });
    std::printf("%10.2f %10.2f %16.2f %16.2f %16.1f\n", loop, event, bare, unasked, asked);
  }
}

void count(int n) {
  math::Random random(1, 2, 3);
  const rt::Step step{rt::Time{}, rt::Duration{1}, false, 3, random};
  volatile std::uint32_t sink = 0;
  for (int i = 0; i < n; ++i) bare_step(step, sink);
  for (int i = 0; i < n; ++i) zoned_step(step, sink);
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--count")
    sinew::bench::count(std::atoi(argv[2]));
  else
    sinew::bench::measure();
}
