#pragma once
#include "control/nav_estimator.hpp"
#include "msg/actuators.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Attitude, velocity and position from inertial samples, range finder, barometer and sightings of the landing pad; all
/// but the inertial samples may be left unbound. See NavEstimator.
/// Frames:  base x forward, y left, z up; world z up, origin on the ground below the start.
/// Thread:  executor, at the rate of the inertial samples (200 to 1000 Hz).   RT: yes.
/// Errors:  stale without a new inertial sample and until the first attitude; fault when no sample of a step can
///          be used (not finite, beyond what an IMU measures, older). Nothing is published then; other messages of that
///          step are used all the same.
class ErrorStateFilter final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { estimator_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;
  const NavEstimator& estimator() const { return estimator_; }

 private:
  void declare_sensors(rt::Declaration& d);
  void declare_levelling(rt::Declaration& d);

  rt::InQueue<msg::ImuSample> imu_;
  rt::InQueue<msg::RangeSample> range_;
  rt::InQueue<msg::BaroSample> baro_;
  rt::InQueue<msg::PadSighting> pad_;
  rt::In<msg::ActuatorCommand> motors_;
  rt::Out<msg::NavState> state_;
  NavEstimator estimator_;
};

}  // namespace sinew::control
