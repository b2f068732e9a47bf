#pragma once
#include "control/nav_estimator.hpp"
#include "msg/actuators.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Attitude, velocity and position from inertial samples, range finder, barometer, sightings of the landing pad, and
/// outdoors GNSS, magnetometer and the ground's motion; all but the inertial samples may be left unbound. See
/// NavEstimator. `report` announces each jump of the state with its size and says what became of each source; it is
/// published only once a GNSS or magnetometer sample has come.
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
  void declare_gnss(rt::Declaration& d);
  void declare_mag(rt::Declaration& d);

  rt::InQueue<msg::ImuSample> imu_;
  rt::InQueue<msg::RangeSample> range_;
  rt::InQueue<msg::BaroSample> baro_;
  rt::InQueue<msg::PadSighting> pad_;
  rt::InQueue<msg::GnssSample> gnss_;
  rt::InQueue<msg::MagSample> mag_;
  rt::InQueue<msg::GroundMotion> motion_;
  rt::In<msg::ActuatorCommand> motors_;
  rt::Out<msg::NavState> state_;
  rt::Out<msg::NavReport> report_;
  NavEstimator estimator_;
};

}  // namespace sinew::control
