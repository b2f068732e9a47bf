#include "apps/calibrate/camera_offset.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "math/random.hpp"

namespace sinew::app::camera_offset_test {
namespace {

using math::Quat;
using math::Vec3;
using ::testing::HasSubstr;

constexpr double kDeg = math::kPi / 180;
const Quat kNominal{0.5, -0.5, 0.5, -0.5};

/// A robot that is turned about all axes, with a camera whose stamps are late and whose mount is off.
struct Turned {
  double late_ms = 0;
  Vec3 mount_deg{};                 // about the optical axes
  Vec3 swing_radps{0.5, 0.4, 0.6};  // of the IMU
  Vec3 arm{};                       // of the camera from the centre of rotation / distance of the scene; optical axes
  double seconds = 20, gyro_noise = 0.004, picture_noise_rad = 0.0005;
  double focal = 1;  // too long by this factor
  std::uint64_t seed = 1;

  Vec3 rate(double t) const {
    const double p = 0.7 * static_cast<double>(seed);
    return {swing_radps.x * (std::sin(2.1 * t + p) + 0.5 * std::sin(5.3 * t)) + 0.0,
            swing_radps.y * (std::sin(2.9 * t + 2 * p) + 0.5 * std::cos(4.1 * t + p)),
            swing_radps.z * (std::cos(1.7 * t + 3 * p) + 0.5 * std::sin(6.1 * t + 1))};
  }
  std::vector<double> gaps_s{};  // from these moments on 50 ms of the IMU are missing

  CameraOffset measured() const {
    CameraOffset offset;
    math::Random noise(seed, 7);
    const Vec3 bias{0.01, -0.006, 0.012};
    const Quat q = kNominal * Quat::exp(kDeg * mount_deg);
    for (int i = 0; i < 1000 * (seconds + 1); ++i) {
      if (std::any_of(gaps_s.begin(), gaps_s.end(), [&](double g) { return 1e-3 * i > g && 1e-3 * i < g + 0.05; }))
        continue;
      msg::ImuSample s;
      s.stamp = msg::Time{1'000'000'000} + std::chrono::microseconds(1000 * i);
      const Vec3 w = rate(1e-3 * i) + bias + gyro_noise * Vec3{noise.normal(), noise.normal(), noise.normal()};
      s.gyro_radps = w.to<msg::Vec3>();
      offset.add(s);
    }
    for (int i = 15; i < 30 * seconds; ++i) {
      const double from = i / 30.0, to = (i + 1) / 30.0;
      Vec3 turn;
      for (int k = 0; k < 20; ++k)
        turn += (to - from) / 20 * q.conjugate().rotate(rate(from + (k + 0.5) / 20 * (to - from)));
      // Travel by the arm looks like a turn: docs of CameraOffset.
      turn = {focal * (turn.x + arm.z * turn.x - arm.x * turn.z), focal * (turn.y + arm.z * turn.y - arm.y * turn.z),
              turn.z};
      turn += picture_noise_rad * Vec3{noise.normal(), noise.normal(), noise.normal()};
      const auto stamp = [&](double t) {
        return msg::Time{1'000'000'000} + msg::Duration{static_cast<std::int64_t>(1e9 * t + 1e6 * late_ms)};
      };
      offset.add(stamp(from), stamp(to), turn);
    }
    return offset;
  }
};

TEST(CameraOffset, DelayAndMountAreFoundWhateverTheSeed) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const double late = 7.0 * static_cast<double>(seed) - 40;
    const Vec3 mount{0.5 * static_cast<double>(seed), -3, 2};
    const CameraOffset offset = Turned{.late_ms = late, .mount_deg = mount, .seed = seed}.measured();
    std::string why;
    const auto found = offset.solve(kNominal, why);
    ASSERT_TRUE(found) << why;
    EXPECT_NEAR(found->time_offset_ms, -late, 1.0) << seed;
    EXPECT_LT(std::abs(found->time_offset_ms + late), 5 * found->time_sigma_ms) << seed;
    EXPECT_LT(norm(found->turned_deg - (kNominal.conjugate() * kNominal * Quat::exp(kDeg * mount)).log() / kDeg), 0.3)
        << seed;
    EXPECT_NEAR(found->scale, 1, 0.01);
    EXPECT_LT(found->time_sigma_ms, 0.5);
  }
}

TEST(CameraOffset, TravelInANearSceneAndAWrongFocalLengthLeaveTheMountAlone) {
  const Vec3 mount{2, 1, -3};
  std::string why;
  const auto found =
      Turned{.late_ms = 12, .mount_deg = mount, .arm = {0.05, 0.1, -0.08}, .focal = 1.07}.measured().solve(kNominal,
                                                                                                           why);
  ASSERT_TRUE(found) << why;
  EXPECT_NEAR(found->time_offset_ms, -12, 0.5);
  EXPECT_NEAR(found->turned_deg.x, mount.x, 0.3);
  EXPECT_NEAR(found->turned_deg.y, mount.y, 0.3);
  EXPECT_NEAR(found->turned_deg.z, mount.z, 0.3);
  EXPECT_NEAR(found->scale, 1.07 * (1 - 0.08), 0.01) << "where they are seen";
}

TEST(CameraOffset, LargeMountErrorsAreFoundToo) {
  std::string why;
  const auto found = Turned{.mount_deg = {12, -15, 10}}.measured().solve(kNominal, why);
  ASSERT_TRUE(found) << why;
  EXPECT_LT(norm(found->turned_deg - Vec3{12, -15, 10}), 0.3);
}

TEST(CameraOffset, AnAxisThatWasNotTurnedIsNamed) {
  std::string why;
  EXPECT_FALSE((Turned{.swing_radps = {0.005, 0.4, 0.6}}.measured().solve(kNominal, why)));
  EXPECT_THAT(why, HasSubstr("too little about the camera's forward axis"));
  EXPECT_FALSE((Turned{.swing_radps = {0.4, 0.005, 0.6}}.measured().solve(kNominal, why)));
  EXPECT_THAT(why, HasSubstr("too little about the camera's right axis"));
}

TEST(CameraOffset, PicturesThatHaveNothingToDoWithTheGyroAreRefused) {
  CameraOffset offset = Turned{.swing_radps = {0.2, 0.2, 0.2}, .picture_noise_rad = 0.2}.measured();
  std::string why;
  EXPECT_FALSE(offset.solve(kNominal, why));
  EXPECT_THAT(why, HasSubstr("the pictures do not turn as the gyro does"));
}

TEST(CameraOffset, TooLittleOfItIsRefused) {
  std::string why;
  EXPECT_FALSE((Turned{.seconds = 2}.measured().solve(kNominal, why)));
  EXPECT_THAT(why, HasSubstr("100 are needed"));
  EXPECT_FALSE(CameraOffset().solve(kNominal, why));
}

TEST(CameraOffset, GapsOfTheImuAreLeftOut) {
  std::string why;
  const auto found = Turned{.late_ms = 20, .gaps_s = {2, 5, 9.5, 14}}.measured().solve(kNominal, why);
  const auto whole = Turned{.late_ms = 20}.measured().solve(kNominal, why);
  ASSERT_TRUE(found && whole) << why;
  EXPECT_LT(found->pairs, whole->pairs - 20);
  EXPECT_NEAR(found->time_offset_ms, -20, 1);
  EXPECT_LT(found->residual_radps, 1.1 * whole->residual_radps);
}

TEST(CameraOffset, AFewWrongTurnsDoNoHarm) {
  CameraOffset offset = Turned{.late_ms = 5}.measured();
  for (int i = 0; i < 30; ++i)
    offset.add(msg::Time{3'000'000'000} + std::chrono::milliseconds(100 * i),
               msg::Time{3'033'000'000} + std::chrono::milliseconds(100 * i), {0.1, -0.1, 0.1});
  std::string why;
  const auto found = offset.solve(kNominal, why);
  ASSERT_TRUE(found) << why;
  EXPECT_NEAR(found->time_offset_ms, -5, 0.5);
  EXPECT_LT(norm(found->turned_deg), 0.3);
}

}  // namespace
}  // namespace sinew::app::camera_offset_test
