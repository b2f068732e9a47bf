#include "rt/safety_text.hpp"

#include "math/elementary.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

std::string in_ms(Duration d) { return format_number(static_cast<double>(d.count()) / 1e6) + " ms"; }

std::string bounds(const FailsafeSpec& f) {
  const std::string low = f.below ? "at least " + format_number(*f.below) : "";
  const std::string high = f.above ? "at most " + format_number(*f.above) : "";
  return low + (f.below && f.above ? ", " : "") + high;
}

/// What a condition that holds has found.
std::string seen(const FailsafeSpec& f, double measured) {
  if (math::is_nan(measured) && f.kind != FailsafeSpec::Kind::value) return "nothing has come on " + f.topic.value;
  const Duration time{static_cast<std::int64_t>(math::is_finite(measured) ? measured * 1e3 : 0) * 1'000'000};
  switch (f.kind) {
    case FailsafeSpec::Kind::silent:
      return f.topic.value + " has been silent for " + in_ms(time) + " (at most " + in_ms(f.time) + ")";
    case FailsafeSpec::Kind::stuck:
      return f.topic.value + " has not changed for " + in_ms(time) + " (at most " + in_ms(f.time) + ")";
    case FailsafeSpec::Kind::value:
      break;
  }
  return f.topic.value + "." + f.field.value + " is " +
         (math::is_finite(measured) ? format_number(measured) : "no number") + " (" + bounds(f) + ")";
}

/// The one thing that is wrong with the command of the first such group.
std::string bad(const ActuatorSpec& a, const msg::SafetyState& s) {
  const std::string command = "the command on " + a.command.value, key = "; actuator." + a.name + '.';
  const std::string value = "channel " + std::to_string(s.bad_channel) + " of " + command + " is ";
  switch (s.bad_fault) {
    case msg::kFaultCount:
      return command + " has " + format_number(s.bad_value) + " channels" + key + "channels is " +
             std::to_string(a.channels);
    case msg::kFaultNotFinite:
      return value + "not finite";
    default: {
      const ActuatorSpec::Range limit = a.limit(s.bad_channel);
      return value + format_number(s.bad_value) + key + "limit is [" + format_number(limit.min) + ", " +
             format_number(limit.max) + "]";
    }
  }
}

}  // namespace

std::string cause_text(const FailsafeSpec& f, double measured) {
  switch (f.kind) {
    case FailsafeSpec::Kind::silent:
      return f.topic.value + " silent for " + in_ms(f.time);
    case FailsafeSpec::Kind::stuck:
      return f.topic.value + " unchanged for " + in_ms(f.time);
    case FailsafeSpec::Kind::value:
      break;
  }
  return seen(f, measured);
}

std::string to_string(const FailsafeSpec& f) {
  using Kind = FailsafeSpec::Kind;
  std::string text = f.kind == Kind::value ? f.topic.value : cause_text(f, 0);
  if (f.kind == Kind::value) {
    text += "." + f.field.value + " not " + bounds(f);
    if (f.time > Duration{0}) text += " for " + in_ms(f.time);
  }
  text += f.action == msg::FailsafeAction::stop ? ": stop" : ": land";
  if (f.stop_after) text += ", stop after " + in_ms(*f.stop_after);
  return text;
}

std::vector<std::string> not_ready(const GraphSpec& spec, const msg::SafetyState& state) {
  std::vector<std::string> reasons;
  if (state.permitted || state.ready) return reasons;
  for (std::size_t i = 0; i < spec.failsafes.size(); ++i) {
    const FailsafeSpec& f = spec.failsafes[i];
    if (state.conditions >> i & 1)
      reasons.push_back(f.name + ": " + seen(f, state.measured[i]));
    else if (state.latched >> i & 1)
      reasons.push_back(f.name + ": has acted; disarm first");
  }
  const auto groups = [&](std::uint32_t bits, const auto& words) {
    for (std::size_t i = 0; i < spec.actuators.size(); ++i)
      if (bits >> i & 1) reasons.push_back(spec.actuators[i].name + ": " + words(spec.actuators[i].command.value));
  };
  groups(state.groups_without_command, [](const std::string& topic) { return "no fresh command on " + topic; });
  std::uint32_t others = state.groups_bad_command;
  for (std::size_t i = 0; i < spec.actuators.size() && others == state.groups_bad_command; ++i)
    if (others >> i & 1) {
      reasons.push_back(spec.actuators[i].name + ": " + bad(spec.actuators[i], state));
      others &= ~(1u << i);
    }
  groups(others, [](const std::string& topic) { return "the command on " + topic + " may not pass either"; });
  groups(state.groups_not_idle, [](const std::string& topic) { return "the command on " + topic + " is not idle"; });
  groups(state.groups_device_refused, [](const std::string&) { return std::string("the device refuses commands"); });
  return reasons;
}

}  // namespace sinew::rt
