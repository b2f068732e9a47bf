#pragma once
#include <string>

#include "drivers/joints/servo.hpp"

namespace sinew::drivers {

/// What is wrong with a joint, for people: "absent", "fault: overload, over-temperature (code 0x8611)",
/// "outside its limits". Empty: nothing is; a joint without torque that answers is well.
std::string joint_words(const ServoFeedback& feedback);

/// Of a joint that answers, has been told to move for more than 3 s and is still not ready: a fault that comes again
/// each time it is enabled, a drive whose enable input is open. Empty: it is none. It changes only with the drive's
/// code.
std::string refusal_words(const ServoFeedback& feedback);

/// Of a joint that has followed setpoints beyond its own limits for more than 3 s: nothing breaks, but it does not go
/// where it is told to. Empty: it is none.
std::string beyond_words(const ServoFeedback& feedback);

}  // namespace sinew::drivers
