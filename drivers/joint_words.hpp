#pragma once
#include <string>

#include "drivers/servo.hpp"

namespace sinew::drivers {

/// What is wrong with a joint, for people: "absent", "fault: overload, over-temperature (code 0x8611)",
/// "outside its limits". Empty: nothing is; a joint without torque that answers is well.
std::string joint_words(const ServoFeedback& feedback);

}  // namespace sinew::drivers
