#pragma once
// The interface of a simulated world to a flight in a test, and a small world that shares no code with the plant.
#include <algorithm>
#include <array>
#include <optional>

#include "math/linear.hpp"
#include "math/random.hpp"
#include "msg/sensors.hpp"

namespace sinew::control::test {

struct Truth {
  math::Vec3 p_world_m, v_world_mps;
  math::Quat q_world_base;
  math::Vec3 gyro_radps;
};

/// The samples that have become available at an instant, delays included.
struct Samples {
  msg::Time now;
  std::optional<msg::ImuSample> imu;
  std::optional<msg::RangeSample> range;
  std::optional<msg::BaroSample> baro;
};

class TestWorld {
 public:
  virtual ~TestWorld() = default;
  /// Advances by 0.25 ms; commands as RotorAllocation orders them.
  virtual Samples step(const std::array<double, 4>& command) = 0;
  virtual Truth truth() const = 0;
  math::Vec3 p_base_camera{0, 0, -0.04};
  math::Quat q_base_optical{0, 0.70710678118654752, -0.70710678118654752, 0};
};

struct QuadModelOptions {
  std::uint64_t seed = 1;
  double mass_kg = 1.2;
  double noise = 1;  // 0: perfect sensors
  math::Vec3 p_start_m{0, 0, 0.12};
  math::Quat q_start;
  math::Vec3 force_world_n;  // constant push, for wind
};

/// A rigid body with four lagging rotors on a flat floor. Written from the equations, with the functions of math/ only,
/// so a flight in it has the same bits everywhere.
class QuadModel final : public TestWorld {
 public:
  explicit QuadModel(const QuadModelOptions& o = {}) : o_(o), noise_(o.seed, 5) {
    p_ = o.p_start_m;
    q_ = o.q_start;
    for (int i = 0; i < 3; ++i) {
      gyro_bias_[i] = o_.noise * noise_.normal(0, 0.01);
      accel_bias_[i] = o_.noise * noise_.normal(0, 0.05);
    }
  }
  Truth truth() const override { return {p_, v_, q_, w_}; }

  Samples step(const std::array<double, 4>& command) override {
    constexpr double kDt = 0.00025;
    move(command, kDt);
    ++steps_;
    Samples s;
    s.now = {steps_ * 250'000};
    if (steps_ % 4 == 0) {
      s.imu.emplace();
      s.imu->stamp = s.now;
      s.imu->gyro_radps = (w_ + gyro_bias_ + random(0.004)).to<msg::Vec3>();
      s.imu->accel_mps2 = (f_base_ + accel_bias_ + random(shaking_ ? 0.4 : 0.06)).to<msg::Vec3>();
    }
    if (steps_ % 40 == 16) {
      const double up = q_.rotate({0, 0, 1}).z;
      s.range.emplace();
      s.range->stamp = s.now;
      s.range->range_m = up > 0.2 ? p_.z / up - 0.04 + o_.noise * noise_.normal(0, 0.006) : math::kNan;
    }
    return s;
  }

 private:
  void move(const std::array<double, 4>& command, double dt) {
    constexpr double kArm = 0.1202, kTorque = 0.016, kMax = 6.0, kLag = 0.03, kDrag = 0.3;
    constexpr double kX[4] = {1, -1, 1, -1}, kY[4] = {-1, 1, 1, -1}, kSpin[4] = {1, 1, -1, -1};
    double thrust = 0;
    math::Vec3 torque;
    for (std::size_t i = 0; i < 4; ++i) {
      thrust_[i] += (std::clamp(command[i], 0.0, 1.0) * kMax - thrust_[i]) * (dt / kLag);
      thrust += thrust_[i];
      torque += math::Vec3{kY[i] * kArm, -kX[i] * kArm, -kSpin[i] * kTorque} * thrust_[i];
    }
    shaking_ = thrust > 1;
    const math::Vec3 inertia{0.011, 0.0112, 0.020};
    math::Vec3 force = q_.rotate({0, 0, thrust}) - kDrag * v_ + o_.force_world_n;
    const math::Vec3 spin{inertia.x * w_.x, inertia.y * w_.y, inertia.z * w_.z};
    const math::Vec3 left = torque - cross(w_, spin);
    math::Vec3 turn{left.x / inertia.x, left.y / inertia.y, left.z / inertia.z};
    math::Vec3 accel = force / o_.mass_kg - math::Vec3{0, 0, 9.81};
    if (p_.z <= 0.12 && (accel.z < 0 || v_.z < 0)) {  // stands on its feet: level, no slip
      accel = v_ = w_ = turn = {};
      q_ = math::Quat::from_axis_angle({0, 0, 1}, q_.yaw());
      p_.z = 0.12;
    }
    f_base_ = q_.conjugate().rotate(accel + math::Vec3{0, 0, 9.81});
    v_ += accel * dt;
    p_ += v_ * dt;
    w_ += turn * dt;
    q_ = (q_ * math::Quat::exp(w_ * dt)).normalized();
  }
  math::Vec3 random(double sigma) {
    const double x = noise_.normal(), y = noise_.normal(), z = noise_.normal();
    return math::Vec3{x, y, z} * (sigma * o_.noise);
  }

  QuadModelOptions o_;
  math::Random noise_;
  std::int64_t steps_ = 0;
  math::Vec3 p_, v_, w_, f_base_{0, 0, 9.81}, gyro_bias_, accel_bias_;
  math::Quat q_;
  std::array<double, 4> thrust_{};
  bool shaking_ = false;
};

}  // namespace sinew::control::test
