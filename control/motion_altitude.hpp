#pragma once
#include <string>

#include "control/motion_altitude_law.hpp"
#include "msg/sensors.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Flies forward at the height that the ground's motion gives. See MotionAltitudeLaw.
/// `height_by` "range" takes the range finder's height in place of the motion's: to compare with.
/// Thread:  executor, 100 to 250 Hz, before the attitude controller's next step.   RT: yes.
/// Errors:  stale without a fresh state; fault when it is not finite. Nothing is published then, and the guardian acts
///          when the lease of the last command runs out.
class MotionAltitude final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void declare_params(rt::Declaration& d);

  rt::In<msg::NavState> state_;
  rt::InQueue<msg::ImuSample> imu_;
  rt::In<msg::GroundMotion> motion_;
  rt::In<msg::RangeSample> range_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::AttitudeSetpoint> attitude_;
  rt::Out<msg::AltitudeState> altitude_;
  std::string height_by_ = "motion";
  bool by_range_ = false;
  MotionAltitudeLaw law_;
  math::Vec3 force_mps2_;
};

}  // namespace sinew::control
