#pragma once
// What a robot file may say of a servo. Each protocol has its own check_...(), which begins with check_servo().
#include <string>
#include <vector>

#include "drivers/joints/servo.hpp"
#include "drivers/key_number.hpp"

namespace sinew::drivers {

/// A key of a robot file that cannot be as it is beside the others, and what it may be. What is set in C++ goes by the
/// same names. "bus.tick_hz": a key of the joint's bus.
struct WrongKey {
  std::string key, allowed;
};
using WrongKeys = std::vector<WrongKey>;

/// "id: an integer from 1 to 127; kp: ..." for people. Empty: nothing is wrong.
std::string to_string(const WrongKeys& all);

/// What is wrong with a configuration whatever its protocol. `derates_speed`: derating needs no max_effort_nm.
WrongKeys check_servo(const ServoConfig& config, bool derates_speed = false);

/// How often something comes, and which key makes it so.
struct Pace {
  Duration every{};
  const char* key = "";  // "the bus's tick_hz"
};
/// Whether its time-outs leave room for what is late: `feedback` is what its driver hears (positions), `life` what the
/// drive hears (our signs of life).
WrongKeys check_times(const ServoConfig& config, const Pace& feedback, const Pace& life);

}  // namespace sinew::drivers
