#pragma once
#include "control/excitation_plan.hpp"
#include "msg/actuators.hpp"
#include "msg/joints.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Moves the joints of one actuator group so that `sinew identify` can tell what they are like: see ExcitationPlan. It
/// goes to the centres slowly first, and holds them when it has done. With `safety` bound it begins when the guardian
/// permits it, gives its joints up when a failsafe stops them, and then begins anew.
/// Units:   commands are positions in rad.
/// Thread:  executor, 50 to 1000 Hz.   RT: yes.
/// Errors:  stale without fresh joints; nothing is published then, and the guardian acts when the last command's lease
///          runs out.
class Excitation final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { run_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  struct Run {
    constexpr Run() = default;
    std::int64_t begun_ns = 0;  // 0: not yet
    std::array<double, msg::kMaxChannels> from_rad{};
  };
  double setpoint_rad(std::size_t joint, double t_s) const noexcept;

  rt::In<msg::JointState> joints_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::ActuatorCommand> command_;
  ExcitationPlan plan_;
  std::int64_t count_ = 1, seed_ = 1;
  double approach_radps_ = 0.5;
  std::array<ExcitationRange, msg::kMaxChannels> range_{};
  Run run_;
};

}  // namespace sinew::control
