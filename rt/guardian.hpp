#pragma once
#include <memory>
#include <vector>

#include "hal/board.hpp"
#include "msg/safety.hpp"
#include "rt/arming.hpp"
#include "rt/failsafe.hpp"
#include "rt/graph_spec.hpp"
#include "rt/module.hpp"

namespace sinew::rt {

/// Stands between every command and its actuators. It alone owns the board's Actuators. The graph makes it from the
/// robot file's actuators, as the most urgent thread, released by each command and at least twice a lease.
///
/// A command passes unchanged, with the rest of its lease, or not at all. Faults are: a wrong number of channels; a
/// value that is not finite, outside its limits or changed faster than allowed; an age (since its commit) that has
/// reached the lease. After a fault the group's safe action takes the command's place until a good command returns.
/// Nothing is clamped: a controller that asks for the impossible is not one to follow half-way. The rate is that
/// against the last good command, over the time between the two commits. A command with armed = 0 stops the group and
/// is not checked.
///
/// Safe actions: after a fault `hold` repeats the last good values; `stop` and `damp` let the device fall back to its
/// own safe action (a joint: its on_stop; motors: off); `torque_off` makes it limp. A group that is not permitted,
/// disarmed, or stopped by a failsafe (unless it holds) is switched off: hal::Actuators::stop().
///
/// No armed command passes without permission (Arming), which the robot file's failsafe conditions can end: their
/// topics are latest inputs. A condition acts in the first step at or after the instant at which it is due: with the
/// next command, at the latest check_interval() later. Topic guardian.state reports all of it, in every step.
///
/// Modes:   standby (no armed command yet, disarmed, or not permitted), armed (every value 0), active, safe (a fault,
///          or stopped by a failsafe).
/// Thread:  executor.   RT: yes.
/// Errors:  configure: what opening the actuators says. A device that refuses is kFaultDevice in the next state.
class Guardian final : public DriverModule {
 public:
  explicit Guardian(const GraphSpec& spec);
  ~Guardian() override;
  /// Half the smallest lease: a lease is noticed at the instant at which it ends, when no other group is in between.
  static Duration check_interval(const std::vector<ActuatorSpec>& actuators);

  void declare(Declaration& d) override;
  hal::Status configure(Setup& setup) override;
  void reset() override;
  StepStatus step(const Step& step) noexcept override;
  void emit(Time now) noexcept override;
  /// Bit i: the device of group i refused the last command.
  std::uint32_t device_state() const noexcept override;
  void set_device_state(std::uint32_t refused) noexcept override;

  /// Stops every group, after the last cycle of a run in real time: a lease may be long, and no command renews it.
  void shut_down() noexcept;

  /// Asks for permission, between two cycles. False: something is not ready; guardian.state says what.
  bool arm() noexcept { return arming_.arm(); }
  /// Ends the permission, in flight too: the actuators stop in the next step.
  void disarm() noexcept { arming_.disarm(); }

 private:
  struct Group;
  std::uint32_t look_at_conditions(Time now) noexcept;
  void write_state(Time now, std::uint32_t conditions) noexcept;

  std::vector<std::unique_ptr<Group>> groups_;  // ports are bound by address
  std::vector<std::unique_ptr<Failsafe>> failsafes_;
  Arming arming_;
  Out<msg::SafetyState> state_;
};

}  // namespace sinew::rt
