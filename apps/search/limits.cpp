#include "apps/search/limits.hpp"

#include <algorithm>

namespace sinew::search {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTogether = 50ms;    // faults of one device nearer than this add up
constexpr Duration kImuGap = 8ms;       // a state of this age is still used (10 ms), and the lease is 20 ms
constexpr Duration kImuDelay = 5ms;     // likewise, and no chain is over its budget of 10 ms
constexpr Duration kMotorGap = 12ms;    // commands come every millisecond with a lease of 20 ms
constexpr Duration kHeightGap = 400ms;  // the estimate calls a height valid for 0.5 s
constexpr Duration kSightingGap = 1s;   // the mission calls the pad lost after 1.5 s

Duration in_ms(double ms) { return Duration{static_cast<std::int64_t>(ms * 1e6)}; }

/// About the longest silence of this fault: the length of bursts is random, and six times their mean is rare.
Duration silence(const Fault& f, Duration period) {
  if (f.kind == "off" || f.kind == "garbage") return f.length;
  if (f.kind == "delayed") return std::min(in_ms(f.amount), f.length) + period;
  if (f.kind == "intermittent") return std::min(in_ms(6 * f.amount), f.length);
  if (f.kind == "slow") return std::min(period * static_cast<std::int64_t>(f.amount), f.length);
  return Duration{0};
}

/// The silence of all faults of this device that are near this one.
Duration silence_around(const Case& c, const Fault& f, Duration period) {
  Duration sum{0};
  for (const Fault& g : c.faults)
    if (g.device == f.device && g.from - f.until() < kTogether && f.from - g.until() < kTogether)
      sum += silence(g, period);
  return sum;
}

/// How long this device may be silent before a failsafe of the robot file acts; samples come once a `period`.
Duration tolerated(const std::string& device, Duration otherwise, Duration period,
                   const std::vector<rt::FailsafeSpec>& failsafes) {
  Duration time = otherwise;
  for (const rt::FailsafeSpec& f : failsafes)
    if (f.kind == rt::FailsafeSpec::Kind::silent && f.topic.value == device + ".raw")
      time = std::min(time, f.time - 3 * period);  // the samples before and after, and their latency
  return time;
}

}  // namespace

Excuses excuses(const Case& c, const std::vector<rt::FailsafeSpec>& failsafes) {
  Excuses e;
  for (const Fault& f : c.faults) {
    if (f.device == "imu") {
      const bool late = f.kind == "delayed" && in_ms(f.amount) > kImuDelay;
      e.failsafe |= f.lies() || late || silence_around(c, f, 1ms) > kImuGap;
    } else if (f.device == "motors") {
      e.failsafe |= f.lies() || f.kind == "garbage" || silence_around(c, f, 1ms) > kMotorGap;
    } else if (f.device == "link") {
      e.failsafe = true;
    } else {
      const bool camera = f.device == "camera";
      const Duration period = camera ? 33ms : 10ms, gap = camera ? kSightingGap : kHeightGap;
      e.elsewhere |= f.lies() || silence_around(c, f, period) > tolerated(f.device, gap, period, failsafes);
    }
  }
  e.elsewhere |= e.failsafe;
  return e;
}

}  // namespace sinew::search
