// The estimator alone, outdoors: a vehicle drives an eight, has no magnetometer, and finds its heading by moving.
//
//   build/release/examples/example_estimate_outdoors
#include <cmath>
#include <cstdio>

#include "control/nav_estimator.hpp"
#include "math/random.hpp"

using namespace sinew;

constexpr double kDt_s = 0.004, kEarth_m = 6'371'000, kDeg = 180 / math::kPi;

int main() {
  math::Random random(1);
  const auto noise = [&](double sigma) { return random.normal(0, sigma); };
  control::NavEstimator estimator;
  double east_m = 0, north_m = 0, yaw = 1, speed_mps = 0;  // truth, which the estimator is not told
  bool good = true;
  for (int i = 0; i < 60 * 250; ++i) {
    const double t = i * kDt_s;
    const double faster_mps2 = t > 5 && t < 10 ? 1 : 0;  // it stands for five seconds, to level
    const double turn_radps = t > 10 ? 0.3 * std::sin(0.25 * t) : 0;
    speed_mps += faster_mps2 * kDt_s;
    yaw += turn_radps * kDt_s;
    east_m += speed_mps * std::cos(yaw) * kDt_s;
    north_m += speed_mps * std::sin(yaw) * kDt_s;

    msg::ImuSample imu;
    imu.stamp.ns = std::int64_t{i} * 4'000'000;
    imu.gyro_radps = {noise(1e-3), noise(1e-3), turn_radps + noise(1e-3)};
    imu.accel_mps2 = {faster_mps2 + noise(0.02), speed_mps * turn_radps + noise(0.02), 9.81 + noise(0.02)};
    estimator.add_imu(imu);

    if (i % 50 == 0) {  // five fixes a second
      msg::GnssSample fix;
      fix.stamp = imu.stamp;
      fix.fix = msg::GnssFix::full, fix.satellites = 12;
      fix.latitude_deg = 47 + (north_m + noise(0.5)) / kEarth_m * kDeg;
      fix.longitude_deg = 8 + (east_m + noise(0.5)) / (kEarth_m * std::cos(47 / kDeg)) * kDeg;
      fix.altitude_m = 450 + noise(1);
      fix.velocity_mps = {speed_mps * std::cos(yaw) + noise(0.1), speed_mps * std::sin(yaw) + noise(0.1), noise(0.1)};
      fix.horizontal_accuracy_m = 0.7, fix.vertical_accuracy_m = 1, fix.speed_accuracy_mps = 0.15;
      estimator.add_gnss(fix);
    }
    msg::NavReport report;
    if (estimator.take_report(report) && i % 1250 < 25) {
      const double off_deg =
          std::remainder(math::Quat(estimator.output().q_world_base).yaw() - yaw, 2 * math::kPi) * kDeg;
      std::printf("%4.0f s  heading %s, off by %6.1f deg, stated +- %5.1f\n", t,
                  report.heading_valid ? "known  " : "unknown", off_deg, 2 * report.heading_std_rad * kDeg);
      good = t < 50 || (report.heading_valid && std::fabs(off_deg) < 4);
    }
  }
  return good ? 0 : 1;
}
