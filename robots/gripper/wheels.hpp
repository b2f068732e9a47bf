#pragma once
#include "msg/flight.hpp"
#include "msg/joints.hpp"
#include "msg/motion.hpp"
#include "rt/module.hpp"

namespace sinew::gripper {

/// Two driven wheels: turns a wanted velocity into their speeds, and says where they have come by encoders and gyro.
/// The gyro's offset is measured while the wheels stand. Frames:  world: where it began, x ahead, z up. Base: between
/// the wheels, on the ground. Thread:  executor, 50 Hz or more.   RT: yes. Errors:  stale without fresh wheels and a
/// fresh gyro: nothing is published, and the wheels stop by their lease. Without
///          a fresh velocity they are told to stand.
class Wheels final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void find_place(const msg::JointState& wheels, const msg::ImuSample& imu);

  rt::In<msg::ImuSample> imu_;
  rt::In<msg::JointState> joints_;
  rt::In<msg::VelocityCommand> velocity_;
  rt::Out<msg::ActuatorCommand> wheels_;
  rt::Out<msg::NavState> state_;
  double radius_m_ = 0.0825, track_m_ = 0.317, most_mps_ = 0.5, most_turn_radps_ = 1.0, accel_mps2_ = 0.8;
  double turn_accel_radps2_ = 3;

  // Saved with a recording.
  double x_m_ = 0, y_m_ = 0, heading_rad_ = 0;
  double forward_mps_ = 0, turn_radps_ = 0;  // told to the wheels
  double left_rad_ = 0, right_rad_ = 0, gyro_offset_radps_ = 0, turn_now_radps_ = 0;
  rt::Time joints_stamp_{}, imu_stamp_{};
  std::uint32_t still_ = 0;         // steps for which the wheels have stood
  std::uint32_t known_ = 0;         // the wheels' angles
  std::uint32_t offset_steps_ = 0;  // in the gyro's offset
};

}  // namespace sinew::gripper
