#include "drivers/joint_text.hpp"

#include <array>
#include <cstdio>

namespace sinew::drivers {
namespace {

struct Words {
  std::uint32_t fault;
  const char* text;
};
constexpr std::array kWords{
    Words{msg::kJointDuplicate, "two drives answer to its number (give one of them another)"},
    Words{msg::kJointEncoder, "its position cannot be believed (encoder, or noise on the bus?)"},
    Words{msg::kJointOverload, "does not follow its setpoint (blocked, or the drive repeats itself?)"},
    Words{msg::kJointOverCurrent, "over-current"},
    Words{msg::kJointOverVoltage, "over-voltage"},
    Words{msg::kJointUnderVoltage, "under-voltage (supply, fuse?)"},
    Words{msg::kJointOverTemperature, "too hot"},
    Words{msg::kJointOther, "its drive reports a fault"},
};

}  // namespace

std::string joint_problem(const ServoFeedback& feedback) {
  std::string text;
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (feedback.faults & msg::kJointLost)
    add("is silent (power, cable, emergency stop?)");
  else if (feedback.mode == msg::JointMode::absent && (feedback.faults & msg::kJointDuplicate) == 0)
    add("has not been heard of yet (power, cable, its number, the bit rate?)");
  for (const Words& w : kWords)
    if (feedback.faults & w.fault) add(w.text);
  if (feedback.fault_code != 0 && (feedback.mode == msg::JointMode::fault)) {
    char code[32];
    std::snprintf(code, sizeof code, "the drive's code is 0x%x", feedback.fault_code);
    add(code);
  }
  return text;
}

}  // namespace sinew::drivers
