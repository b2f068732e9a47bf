#pragma once
#include <cstdint>

#include "hal/clock.hpp"

namespace sinew::sim_hil {

/// The clock of a simulated robot: where it stands at plant time 0, and how much faster than plant time it runs. Its
/// readings never decrease with plant time.
/// RT: yes.
struct RobotClock {
  hal::Duration offset{0};
  std::int64_t drift_ppb = 0;  // nanoseconds per second, at most 1e6 either way

  bool is_plant_time() const { return offset.count() == 0 && drift_ppb == 0; }
  /// What it reads at a plant time.
  hal::Time to_robot(hal::Time plant) const { return {plant.ns + offset.count() + gained_ns(plant.ns)}; }
  /// The first plant time at which it reads that, or more.
  hal::Time to_plant(hal::Time robot) const {
    if (is_plant_time()) return robot;
    std::int64_t t = robot.ns - offset.count();
    for (int i = 0; i < 4; ++i) t -= to_robot({t}).ns - robot.ns;  // each time a thousand times closer
    while (to_robot({t}).ns >= robot.ns) --t;
    while (to_robot({t}).ns < robot.ns) ++t;
    return {t};
  }

 private:
  static constexpr std::int64_t kNsPerS = 1'000'000'000;
  static std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }
  /// floor(t * drift_ppb / 1e9), without overflow for years.
  std::int64_t gained_ns(std::int64_t t) const {
    const std::int64_t whole_s = floor_div(t, kNsPerS);
    return whole_s * drift_ppb + floor_div((t - whole_s * kNsPerS) * drift_ppb, kNsPerS);
  }
};

}  // namespace sinew::sim_hil
