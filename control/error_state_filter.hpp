#pragma once
#include <vector>

#include "control/imu_selector.hpp"
#include "control/nav_estimator.hpp"
#include "msg/actuators.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Attitude, velocity and position from inertial samples, range finder, barometer, sightings of the landing pad, and
/// outdoors GNSS, magnetometer and the ground's motion; all but the inertial samples may be left unbound. See
/// NavEstimator. `report` announces each jump of the state with its size and says what became of each source; it is
/// published only once a GNSS or magnetometer sample has come.
/// With `imus` 2 or 3 (inputs imu2, imu3) each IMU has an estimator, and ImuSelector says whose state is published. A
/// change is announced like any other jump.
/// Frames:  base x forward, y left, z up; world z up, origin on the ground below the start.
/// Thread:  executor, at the rate of the inertial samples (200 to 1000 Hz).   RT: yes.
/// Errors:  stale without a new inertial sample and until the first attitude; fault when no sample of a step can
///          be used (not finite, beyond what an IMU measures, older). Nothing is published then; other messages of that
///          step are used all the same.
class ErrorStateFilter final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;
  /// Of the first IMU.
  const NavEstimator& estimator() const { return estimator_; }

 private:
  void declare_sensors(rt::Declaration& d);
  void declare_levelling(rt::Declaration& d);
  void declare_gnss(rt::Declaration& d);
  void declare_mag(rt::Declaration& d);

  bool add_messages(NavEstimator& nav, const rt::InQueue<msg::ImuSample>& imu) noexcept;
  const rt::InQueue<msg::ImuSample>& queue_of(std::uint32_t imu) const {
    return imu == 0 ? imu_ : imu == 1 ? imu2_ : imu3_;
  }
  NavEstimator& choose_imu(const rt::Step& step) noexcept;

  rt::InQueue<msg::ImuSample> imu_, imu2_, imu3_;
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
  std::vector<NavEstimator> others_;  // of the second and third IMU, if they are bound
  ImuSelector selector_;
  std::int64_t imus_ = 1;
};

}  // namespace sinew::control
