#include "robots/gripper/wheels.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "math/linear.hpp"

namespace sinew::gripper {

using namespace std::chrono_literals;

namespace {

constexpr double kStill_radps = 0.02;        // of a wheel
constexpr std::uint32_t kStillSteps = 20;    // the body has stopped rocking
constexpr std::uint32_t kOffsetSteps = 200;  // that the gyro's offset is the mean of

double toward(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

}  // namespace

void Wheels::declare(rt::Declaration& d) {
  d.in("imu", imu_, {.max_age = 100ms});
  d.in("joints", joints_, {.max_age = 100ms});
  d.in("velocity", velocity_, {.max_age = 300ms});
  d.out("wheels", wheels_, {.channels = 2});
  d.out("state", state_);
  d.state(x_m_, y_m_, heading_rad_, forward_mps_, turn_radps_, left_rad_, right_rad_, gyro_offset_radps_,
          turn_now_radps_, joints_stamp_, imu_stamp_, still_, known_, offset_steps_);
  d.param("radius_m", radius_m_, {.unit = "m", .min = 0.01, .max = 0.5, .doc = "of a wheel"});
  d.param("track_m", track_m_, {.unit = "m", .min = 0.05, .max = 2, .doc = "between the wheels' middles"});
  d.param("most_mps", most_mps_, {.unit = "m/s", .min = 0.05, .max = 1.6, .doc = "it drives no faster"});
  d.param("most_turn_radps", most_turn_radps_, {.unit = "rad/s", .min = 0.05, .max = 5, .doc = "it turns no faster"});
  d.param("accel_mps2", accel_mps2_, {.unit = "m/s^2", .min = 0.1, .max = 5, .doc = "how fast its speed changes"});
  d.param("turn_accel_radps2", turn_accel_radps2_,
          {.unit = "rad/s^2", .min = 0.1, .max = 20, .doc = "how fast its turning changes"});
}

void Wheels::reset() {
  x_m_ = y_m_ = heading_rad_ = forward_mps_ = turn_radps_ = 0;
  left_rad_ = right_rad_ = gyro_offset_radps_ = turn_now_radps_ = 0;
  joints_stamp_ = imu_stamp_ = {};
  still_ = known_ = offset_steps_ = 0;
}

/// The way by the encoders, the heading by the gyro: wide tyres scrub in a turn, and encoders do not see it.
void Wheels::find_place(const msg::JointState& wheels, const msg::ImuSample& imu) {
  const double left = wheels.position_rad[0], right = wheels.position_rad[1];
  const bool stands =
      math::fabs(wheels.velocity_radps[0]) < kStill_radps && math::fabs(wheels.velocity_radps[1]) < kStill_radps;
  still_ = stands ? std::min(still_ + 1, kStillSteps) : 0;
  if (still_ == kStillSteps) {
    offset_steps_ = std::min(offset_steps_ + 1, kOffsetSteps);
    gyro_offset_radps_ += (imu.gyro_radps.z - gyro_offset_radps_) / offset_steps_;
  }
  turn_now_radps_ = still_ == kStillSteps ? 0 : imu.gyro_radps.z - gyro_offset_radps_;
  if (known_ != 0) {
    const double dt_s = msg::seconds(imu.stamp - imu_stamp_);
    const double turn = turn_now_radps_ * dt_s;
    const double way = radius_m_ * (left - left_rad_ + right - right_rad_) / 2;
    const math::SinCos ahead = math::sincos(heading_rad_ + turn / 2);
    x_m_ += way * ahead.cos;
    y_m_ += way * ahead.sin;
    heading_rad_ = math::wrap_pi(heading_rad_ + turn);
  }
  known_ = 1;
  left_rad_ = left, right_rad_ = right;
  joints_stamp_ = wheels.stamp;
  imu_stamp_ = imu.stamp;
}

rt::StepStatus Wheels::step(const rt::Step& step) noexcept {
  const msg::JointState* wheels = joints_.fresh(step.now);
  const msg::ImuSample* imu = imu_.fresh(step.now);
  if (!wheels || !imu || wheels->count < 2) return rt::StepStatus::stale;
  if (!math::is_finite(wheels->position_rad[0]) || !math::is_finite(wheels->position_rad[1]) ||
      !math::is_finite(imu->gyro_radps.z))
    return rt::StepStatus::stale;
  if (wheels->stamp != joints_stamp_) find_place(*wheels, *imu);

  const msg::VelocityCommand* wanted = velocity_.fresh(step.now);
  const double dt_s = msg::seconds(step.dt);
  const double forward = wanted ? std::clamp(wanted->linear_mps.x, -most_mps_, most_mps_) : 0;
  const double turn = wanted ? std::clamp(wanted->angular_radps.z, -most_turn_radps_, most_turn_radps_) : 0;
  forward_mps_ = toward(forward_mps_, forward, accel_mps2_ * dt_s);
  turn_radps_ = toward(turn_radps_, turn, turn_accel_radps2_ * dt_s);
  msg::ActuatorCommand& command = wheels_.loan();
  command.stamp = wheels->stamp;
  command.count = 2;
  command.armed = 1;
  command.value[0] = (forward_mps_ - turn_radps_ * track_m_ / 2) / radius_m_;
  command.value[1] = (forward_mps_ + turn_radps_ * track_m_ / 2) / radius_m_;

  msg::NavState& state = state_.loan();
  state.stamp = wheels->stamp;
  state.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, heading_rad_).to<msg::Quat>();
  state.p_world_m = {x_m_, y_m_, 0};
  const double speed = radius_m_ * (wheels->velocity_radps[0] + wheels->velocity_radps[1]) / 2;
  const math::SinCos ahead = math::sincos(heading_rad_);
  state.v_world_mps = {speed * ahead.cos, speed * ahead.sin, 0};
  state.gyro_radps = {0, 0, turn_now_radps_};
  state.gyro_bias_radps = {0, 0, gyro_offset_radps_};
  state.attitude_valid = state.position_valid = 1;
  state.at_rest = still_ == kStillSteps ? 1 : 0;
  return rt::StepStatus::ok;
}

}  // namespace sinew::gripper
