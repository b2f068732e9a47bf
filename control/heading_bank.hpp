#pragma once
#include <array>
#include <optional>

#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

/// Heading from how the velocity changes: what the accelerometer felt, turned by the right heading, is what the GNSS
/// velocity shows. No magnetometer, and nothing of the main filter, so that it can contradict both.
///
/// A tilt filter of its own sums the horizontal acceleration in a frame that turns with nothing but the gyro. Between
/// two velocities that frame differs from east and north by one angle, which hardly changes. Eight small Kalman filters
/// (east and north velocity, angle), started 45 degrees apart, each predict with the sum and are weighed by how well
/// they foretold the next velocity; heading and its uncertainty are those of the weighted sum.
/// Frames:  world x east, y north, z up; heading of base x, counter-clockwise from east (NavState's yaw).
/// Shape:   8 filters of 3 states; sums of the last third of a second, so that a late velocity is used at its own time.
/// Thread:  owner.   RT: yes.
/// Errors:  none; std_rad() stays near pi/sqrt(3) = 1.8 as long as nothing accelerates, and no heading is taken then.
class HeadingBank {
 public:
  struct Params {
    double accel_noise = 0.35;  // m/s per root second: tilt error and vibration
    double angle_walk = 0.01;   // rad per root second: gyro bias and noise
    double tilt_gain = 0.15;    // 1/s towards the accelerometer, less when it feels no 1 g
  };
  Params params;

  void reset() {
    const Params keep = params;
    *this = HeadingBank{};
    params = keep;
  }
  /// One inertial sample; `gyro_radps` without the known bias.
  void add_imu(msg::Time stamp, const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s);
  /// A velocity (east, north) that was valid at `stamp`. One sigma of each component.
  void add_velocity(msg::Time stamp, double east_mps, double north_mps, double sigma_mps);

  /// Heading of base x now. Nothing useful while std_rad() is large.
  double heading_rad() const;
  double std_rad() const;

 private:
  static constexpr std::size_t kFilters = 8, kSums = 64;
  struct Filter {
    double east_mps = 0, north_mps = 0, angle_rad = 0, weight = 0;
    math::Mat<3, 3> p;
  };
  struct Sum {
    msg::Time stamp;
    math::Vec3 dv_mps;  // since the start, in the gyro's frame
  };
  std::optional<math::Vec3> sum_at(msg::Time t) const;
  void start(double east_mps, double north_mps, double sigma_mps);
  math::Vec3 mean_direction() const;

  std::array<Filter, kFilters> filters_{};
  std::array<Sum, kSums> sums_{};
  math::Quat q_level_base_;  // the gyro's frame: z up, turned by nothing but the gyro
  math::Vec3 dv_mps_, dv_before_mps_;
  msg::Time before_;
  std::uint32_t first_ = 0, count_ = 0, levelled_ = 0, running_ = 0;
};

}  // namespace sinew::control
