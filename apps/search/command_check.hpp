#pragma once
#include "apps/search/verdict.hpp"
#include "msg/actuators.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::search {

/// Checks the commands that reach the actuators of one group. Invariants:
///   lease     no setpoint is valid for longer than the lease after the commit of its command, nor, counted from the
///             measurement behind it, than the oldest input that its writer takes and the lease
///   stamp     no setpoint claims a measurement newer than any that the robot has
///   command   every setpoint is finite, within its limits, and one per channel
/// Thread:  owner.
class CommandCheck {
 public:
  /// `oldest_input`: the largest age at which the writer of the command still takes its input.
  CommandCheck(const rt::ActuatorSpec& spec, msg::Duration oldest_input, Verdict& verdict)
      : spec_(spec), oldest_input_(oldest_input), verdict_(verdict) {}

  /// The writer of the command latched its inputs at `began` and committed at `at`.
  void committed(msg::Time began, msg::Time at) { began_ = began, committed_ = at; }
  /// The newest measurement that any chain to the actuators begins with.
  void measured(msg::Time newest) { newest_ = newest; }
  void written(msg::Time now, const msg::ActuatorCommand& command, msg::Duration lease);
  void stopped(msg::Time now) { valid_until_ = now; }

  /// The motors have a command up to here; before the first one: the beginning of time.
  msg::Time valid_until() const { return valid_until_; }

 private:
  void check_lease(msg::Time now, const msg::ActuatorCommand& command, msg::Duration lease);

  const rt::ActuatorSpec spec_;
  const msg::Duration oldest_input_;
  Verdict& verdict_;
  msg::Time began_, committed_, valid_until_, newest_{INT64_MAX};
};

}  // namespace sinew::search
