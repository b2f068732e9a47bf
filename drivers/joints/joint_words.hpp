#pragma once
#include <string>

#include "drivers/joints/servo.hpp"

namespace sinew::drivers {

/// msg::JointFault bits for people: "encoder, over-temperature"; 0: empty.
std::string fault_words(std::uint32_t faults);

/// What is wrong with a joint, for people: "absent", "fault: overload, over-temperature (code 0x8611)",
/// "outside its limits". Empty: nothing is; a joint without torque that answers is well.
std::string joint_words(const ServoFeedback& feedback);

/// Words for a joint that answers, has been told to move for more than 3 s and is still not ready: e.g. a fault comes
/// back each time it is enabled, or the drive's enable input is open. Empty: not such a joint. The text changes only
/// with the drive's code.
std::string refusal_words(const ServoFeedback& feedback);

/// Words for a joint that has followed setpoints beyond its own limits for more than 3 s: nothing breaks, but it does
/// not go where it is told to. Empty: not such a joint.
std::string beyond_words(const ServoFeedback& feedback);

}  // namespace sinew::drivers
