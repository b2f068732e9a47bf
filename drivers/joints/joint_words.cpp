#include "drivers/joints/joint_words.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace sinew::drivers {
namespace {

constexpr std::array<std::pair<std::uint32_t, const char*>, 11> kFaults{
    {{msg::kJointOverCurrent, "over-current"},
     {msg::kJointOverVoltage, "over-voltage"},
     {msg::kJointUnderVoltage, "under-voltage"},
     {msg::kJointOverTemperature, "over-temperature"},
     {msg::kJointDerated, "warm, its effort is limited"},
     {msg::kJointEncoder, "encoder"},
     {msg::kJointOverload, "overload (stuck, or too far behind its setpoint)"},
     {msg::kJointLost, "silent for longer than its time-out"},
     {msg::kJointLimit, "outside its limits"},
     {msg::kJointOther, "the drive says so"},
     {msg::kJointDuplicate, "two drives answer to its number"}}};

constexpr Duration kPatience = std::chrono::seconds(3);  // more than the longest pause between two attempts

std::string code_text(std::uint32_t code) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%04x", static_cast<unsigned>(code));
  return text;
}

}  // namespace

std::string fault_words(std::uint32_t faults) {
  std::string all;
  for (const auto& [bit, words] : kFaults)
    if ((faults & bit) != 0) all += (all.empty() ? "" : ", ") + std::string(words);
  return all;
}

std::string joint_words(const ServoFeedback& feedback) {
  const bool absent = feedback.mode == msg::JointMode::absent;
  std::string faults = fault_words(feedback.faults);
  if (absent && feedback.measured.ns == 0) return faults.empty() ? "absent" : "absent; " + faults;
  if (absent) return faults.empty() ? "absent, it was there before" : "absent; " + faults;
  const bool fault = feedback.mode == msg::JointMode::fault;
  if (!fault && faults.empty()) return {};
  if (fault && feedback.fault_code != 0) faults += " (code " + code_text(feedback.fault_code) + ")";
  if (!fault) return faults;
  return faults.empty() ? "fault" : "fault: " + faults;
}

std::string refusal_words(const ServoFeedback& feedback) {
  using msg::JointMode;
  const JointMode m = feedback.mode;
  const bool refuses = m == JointMode::disabled || m == JointMode::enabling || m == JointMode::fault;
  if (!refuses || feedback.refusing <= kPatience) return {};
  const std::string last = feedback.fault_code == 0 ? "its enable input is open, or it has to be disarmed first?"
                                                    : "the last fault code is " + code_text(feedback.fault_code);
  return "told to move for more than 3 s, and not ready (" + last + ")";
}

std::string beyond_words(const ServoFeedback& feedback) {
  if (feedback.mode != msg::JointMode::enabled || feedback.beyond <= kPatience) return {};
  return "told for more than 3 s to go beyond its own limits, and stays within them";
}

}  // namespace sinew::drivers
