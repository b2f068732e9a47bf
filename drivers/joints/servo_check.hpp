#pragma once
// What a robot file may say of a servo. Each protocol has its own check_...(), which begins with check_servo().
#include <string>
#include <vector>

#include "drivers/joints/servo.hpp"
#include "drivers/key_number.hpp"

namespace sinew::drivers {

/// A key of a robot file whose value does not fit the others, and the values that do. Configurations made in C++ use
/// the same names. "bus.tick_hz": a key of the joint's bus.
struct WrongKey {
  std::string key, allowed;
};
using WrongKeys = std::vector<WrongKey>;

/// "id: an integer from 1 to 127; kp: ..." for people. Empty: nothing is wrong.
std::string to_string(const WrongKeys& all);

/// Problems that do not depend on the protocol. `derates_speed`: derating needs no max_effort_nm.
WrongKeys check_servo(const ServoConfig& config, bool derates_speed = false);

/// How often something comes, and the key that sets it.
struct Pace {
  Duration every{};
  const char* key = "";  // "the bus's tick_hz"
};
/// Checks that its time-outs leave room for late frames. `feedback`: frames that the driver hears (positions); `life`:
/// frames that the drive hears (our signs of life).
WrongKeys check_times(const ServoConfig& config, const Pace& feedback, const Pace& life);

}  // namespace sinew::drivers
