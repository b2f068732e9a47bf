#pragma once
#include <algorithm>

#include "math/elementary.hpp"
#include "msg/actuators.hpp"
#include "msg/sensors.hpp"
#include "rt/module.hpp"

namespace sinew::robots {

/// Brings the beam to the level and keeps it there: a complementary filter of the IMU, and a PD law.
/// Frames:  base: of the beam, x along it, y the hinge's axis, z up. Thread: executor. RT: yes.
/// Errors:  stale while there is no sample.
class Balance final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("imu", imu_);
    d.out("motor", motor_);
    d.param("stiffness", stiffness_,
            {.unit = "1/rad", .min = 0, .max = 100, .doc = "command for each rad off the level"});
    d.param("damping", damping_, {.unit = "s/rad", .min = 0, .max = 100, .doc = "command for each rad/s of turning"});
    d.state(pitch_rad_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const msg::ImuSample* imu = imu_.get();
    if (!imu) return rt::StepStatus::stale;
    const double gravity_rad = math::atan2(-imu->accel_mps2.x, imu->accel_mps2.z);
    const double rate_radps = imu->gyro_radps.y;
    pitch_rad_ += rate_radps * msg::seconds(step.dt);
    pitch_rad_ += kTrust * (gravity_rad - pitch_rad_);
    msg::ActuatorCommand& out = motor_.loan();
    out.stamp = step.now;
    out.count = 1;
    out.armed = 1;
    out.value[0] = std::clamp(-stiffness_ * pitch_rad_ - damping_ * rate_radps, -1.0, 1.0);
    return rt::StepStatus::ok;
  }

 private:
  static constexpr double kTrust = 0.01;  // in the accelerometer, a cycle of 1 ms
  rt::In<msg::ImuSample> imu_;
  rt::Out<msg::ActuatorCommand> motor_;
  double stiffness_ = 6, damping_ = 1.5;
  double pitch_rad_ = 0;
};

}  // namespace sinew::robots
