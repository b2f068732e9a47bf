#include "apps/search/command_check.hpp"

#include <fmt/format.h>

#include <cmath>

namespace sinew::search {
namespace {

double ms(msg::Duration d) { return 1e-6 * static_cast<double>(d.count()); }

}  // namespace

void CommandCheck::check_lease(msg::Time now, const msg::ActuatorCommand& command, msg::Duration lease) {
  const msg::Time until = now + lease;
  if (until > committed_ + spec_.lease)
    verdict_.fail("lease", now,
                  fmt::format("{}: a setpoint is valid for {:.3f} ms although its command came {:.3f} ms ago and its "
                              "lease is {:.3f} ms",
                              spec_.name, ms(lease), ms(now - committed_), ms(spec_.lease)));
  const msg::Duration oldest = oldest_input_ + (committed_ - began_) + spec_.lease;
  if (until - command.stamp > oldest)
    verdict_.fail("lease", now,
                  fmt::format("{}: a setpoint acts until {:.3f} ms after the measurement behind it, at most {:.3f} ms",
                              spec_.name, ms(until - command.stamp), ms(oldest)));
}

void CommandCheck::written(msg::Time now, const msg::ActuatorCommand& command, msg::Duration lease) {
  if (spec_.safe != rt::ActuatorSpec::Safe::hold) check_lease(now, command, lease);
  if (command.armed && command.stamp > newest_)
    verdict_.fail("stamp", now,
                  fmt::format("{}: a setpoint claims a measurement {:.3f} ms newer than any that there is", spec_.name,
                              ms(command.stamp - newest_)));
  if (command.count != spec_.channels)
    verdict_.fail("command", now,
                  fmt::format("{}: {} channels instead of {}", spec_.name, command.count, spec_.channels));
  for (std::uint32_t i = 0; i < command.count && i < msg::kMaxChannels; ++i) {
    const double v = command.value[i];
    if (!std::isfinite(v) || v < spec_.min || v > spec_.max)
      verdict_.fail("command", now,
                    fmt::format("{}[{}]: {} went out, limits are {} to {}", spec_.name, i, v, spec_.min, spec_.max));
  }
  valid_until_ = command.armed ? now + lease : now;
}

}  // namespace sinew::search
