#pragma once
#include <string>

#include "drivers/servo.hpp"

namespace sinew::drivers {

/// What is wrong with a joint, in words for people; empty: nothing (warm or at a limit is nothing).
std::string joint_problem(const ServoFeedback& feedback);

}  // namespace sinew::drivers
