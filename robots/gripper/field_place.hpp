#pragma once
#include "msg/flight.hpp"
#include "msg/soccer.hpp"
#include "rt/module.hpp"

namespace sinew::gripper {

/// Where a robot is on the field that knows where it started and follows its own way from there. It sees no lines: its
/// place becomes less sure with the way.
/// Frames:  in: world of the NavState, where the robot began, x ahead; out: "field" of msg/soccer.hpp.
/// Thread:  executor, after what publishes the state.   RT: yes.
/// Errors:  stale without a fresh state: nothing is published.
class FieldPlace final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::Out<msg::FieldPose> pose_;
  double start_x_m_ = 0, start_y_m_ = 0, start_heading_deg_ = 0;
  double start_sigma_m_ = 0.02, way_sigma_ = 0.02, heading_sigma_rad_ = 0.03;

  // Saved with a recording.
  double way_m_ = 0, x_m_ = 0, y_m_ = 0;
};

}  // namespace sinew::gripper
