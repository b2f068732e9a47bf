#include "vision/motion_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "dataset/dataset_folder.hpp"
#include "images.hpp"
#include "vision/luma.hpp"

namespace sinew::vision::motion_grid_test {
namespace {

using msg::PixelFormat;
using test::Pixels;

/// Smooth random texture with features of a few pixels to a few tens, defined everywhere.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) {
    math::Random random(seed);
    for (Wave& w : waves_) {
      const double period = 6 * std::exp(random.uniform() * 2.3), angle = random.uniform() * 2 * M_PI;
      w = {2 * M_PI / period * std::cos(angle), 2 * M_PI / period * std::sin(angle), random.uniform() * 2 * M_PI};
    }
  }
  double at(double x, double y) const {
    double v = 0;
    for (const Wave& w : waves_) v += std::cos(w.kx * x + w.ky * y + w.phase);
    return 128 + 11 * v;
  }

 private:
  struct Wave {
    double kx, ky, phase;
  };
  Wave waves_[16];
};

Pixels shot(const Texture& texture, double dx, double dy, double noise, std::uint64_t seed, double gain = 1,
            double offset = 0, std::uint32_t width = 208, std::uint32_t height = 160) {
  Pixels p(PixelFormat::mono8, width, height);
  math::Random random(seed);
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x)
      p.row(y)[x] = static_cast<std::uint8_t>(
          std::clamp(std::lround(gain * texture.at(x - dx, y - dy) + offset + noise * random.normal()), 0L, 255L));
  return p;
}

msg::MotionField motion(const Pixels& a, const Pixels& b, const MotionOptions& options = {}) {
  msg::MotionField out;
  EXPECT_TRUE(estimate_motion(a.view(), b.view(), options, out));
  return out;
}

// The identity that the header states, against its right-hand side computed pixel by pixel.
TEST(MotionGrid, CorrelatorWithoutBordersIsDifferenceTimesGradient) {
  Pixels a(PixelFormat::mono8, 90, 70), b(PixelFormat::mono8, 90, 70);
  test::fill_noise(a.bytes().data(), a.bytes().size(), 1);
  test::fill_noise(b.bytes().data(), b.bytes().size(), 2);
  for (const PixelRect r : {PixelRect{1, 1, 89, 69}, PixelRect{5, 9, 30, 20}, PixelRect{40, 40, 48, 69}}) {
    double tx = 0, ty = 0, t = 0, gx = 0, gy = 0, gxx = 0;
    const auto s = [&](std::uint32_t x, std::uint32_t y) { return a.row(y)[x] + b.row(y)[x]; };
    for (std::uint32_t y = r.y0; y < r.y1; ++y)
      for (std::uint32_t x = r.x0; x < r.x1; ++x) {
        const double d = b.row(y)[x] - a.row(y)[x];
        const double x_step = s(x + 1, y) - s(x - 1, y), y_step = s(x, y + 1) - s(x, y - 1);
        t += d, tx += d * x_step, ty += d * y_step, gx += x_step, gy += y_step, gxx += x_step * x_step;
      }
    const double n = (r.x1 - r.x0) * (r.y1 - r.y0);
    for (const Simd simd : {Simd::scalar, best_simd()}) {
      const CellMotion m = detail::cell_motion(a.view(), b.view(), r, simd);
      EXPECT_NEAR(m.tx, tx - t * gx / n, 1e-3);
      EXPECT_NEAR(m.ty, ty - t * gy / n, 1e-3);
      EXPECT_NEAR(m.gxx, gxx - gx * gx / n, 1e-3);
    }
  }
}

TEST(MotionGrid, SignsAreRightAndDownForAllFourDirections) {
  const Texture texture(3);
  const Pixels still = shot(texture, 0, 0, 2, 1);
  for (const auto& [dx, dy] : {std::pair{0.5, 0.0}, {-0.5, 0.0}, {0.0, 0.5}, {0.0, -0.5}}) {
    const msg::MotionField m = motion(still, shot(texture, dx, dy, 2, 2));
    EXPECT_EQ(m.moving, 1u);
    EXPECT_GT(m.moving_fraction, 0.9);
    EXPECT_NEAR(m.speed_x_px, dx, 0.1);
    EXPECT_NEAR(m.speed_y_px, dy, 0.1);
    EXPECT_NEAR(m.mean_x, dx, 0.1);
    for (std::size_t i = 0; i < m.x.size(); ++i) EXPECT_GT(m.x[i] * dx + m.y[i] * dy, 0) << i;
  }
}

TEST(MotionGrid, SpeedIsWithinAFifthUpToOnePixelAndTwoFifthsUpToTwo) {
  double worst_slow = 0, worst_fast = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Texture texture(seed);
    const Pixels still = shot(texture, 0, 0, 2, seed);
    for (const double speed : {0.3, 0.6, 1.0, 1.5, 2.0})
      for (const double angle : {0.0, 0.9, 2.2, 4.0}) {
        const double dx = speed * std::cos(angle), dy = speed * std::sin(angle);
        const msg::MotionField m = motion(still, shot(texture, dx, dy, 2, seed + 100));
        const double error = std::hypot(m.speed_x_px - dx, m.speed_y_px - dy) / speed;
        double& worst = speed <= 1 ? worst_slow : worst_fast;
        worst = std::max(worst, error);
        EXPECT_EQ(m.moving, 1u);
      }
  }
  RecordProperty("worst_relative_error_to_1px", std::to_string(worst_slow));
  RecordProperty("worst_relative_error_to_2px", std::to_string(worst_fast));
  std::printf("largest relative error: %.3f up to 1 px per frame, %.3f up to 2\n", worst_slow, worst_fast);
  EXPECT_LT(worst_slow, 0.2);
  EXPECT_LT(worst_fast, 0.4);
}

TEST(MotionGrid, BinsOfFourPixelsFollowSixPixelsPerFrame) {
  const Texture texture(4);
  Luma a(208 * 160), b(208 * 160);
  ASSERT_TRUE(a.take(shot(texture, 0, 0, 2, 1).view(), 4));
  ASSERT_TRUE(b.take(shot(texture, 6, -3, 2, 2).view(), 4));
  EXPECT_EQ(a.view().width, 52u);
  msg::MotionField m;
  EXPECT_FALSE(estimate_motion(a.view(), b.view(), {}, m));  // 52 x 40: cells of 3 pixels are too small
  const Texture large(5);
  Luma c(1280 * 960), d(1280 * 960);
  ASSERT_TRUE(c.take(shot(large, 0, 0, 2, 1, 1, 0, 640, 480).view(), 4));
  ASSERT_TRUE(d.take(shot(large, 6, -3, 2, 2, 1, 0, 640, 480).view(), 4));
  ASSERT_TRUE(estimate_motion(c.view(), d.view(), {}, m));
  EXPECT_NEAR(4 * m.speed_x_px, 6, 1.5);
  EXPECT_NEAR(4 * m.speed_y_px, -3, 1.5);
}

TEST(MotionGrid, NoiseAndChangesOfBrightnessAreNoMotion) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Texture texture(seed);
    const Pixels still = shot(texture, 0, 0, 2, seed);
    for (const auto& [gain, offset] : {std::pair{1.0, 0.0}, {1.0, 12.0}, {0.93, 0.0}, {1.05, -6.0}}) {
      const msg::MotionField m = motion(still, shot(texture, 0, 0, 2, seed + 50, gain, offset));
      EXPECT_EQ(m.moving, 0u) << gain << ' ' << offset;
      EXPECT_LT(std::hypot(m.speed_x_px, m.speed_y_px), 0.05);
    }
  }
}

TEST(MotionGrid, APlainNoisyPictureHasNoMotionToShow) {
  Pixels a(PixelFormat::mono8, 320, 240), b(PixelFormat::mono8, 320, 240);
  math::Random random(1);
  for (auto* p : {&a, &b})
    for (auto& v : p->bytes()) v = static_cast<std::uint8_t>(120 + std::lround(2 * random.normal()));
  const msg::MotionField m = motion(a, b);
  EXPECT_EQ(m.moving, 0u);
  EXPECT_EQ(m.moving_fraction, 0);
  EXPECT_EQ(m.speed_x_px, 0);
}

TEST(MotionGrid, ScalarAndSimdGiveTheSameField) {
  const Texture texture(9);
  const Pixels a = shot(texture, 0, 0, 3, 1, 1, 0, 338, 250), b = shot(texture, 0.7, 0.4, 3, 2, 1, 0, 338, 250);
  msg::MotionField s, v;
  ASSERT_TRUE(estimate_motion(a.view(), b.view(), {}, s, Simd::scalar));
  ASSERT_TRUE(estimate_motion(a.view(), b.view(), {}, v, best_simd()));
  EXPECT_EQ(std::memcmp(&s, &v, sizeof s), 0);
}

TEST(MotionGrid, FramesThatDoNotMatchAreRefused) {
  const Pixels a(PixelFormat::mono8, 320, 240), b(PixelFormat::mono8, 320, 238), small(PixelFormat::mono8, 127, 240);
  msg::MotionField m;
  EXPECT_FALSE(estimate_motion(a.view(), b.view(), {}, m));
  EXPECT_FALSE(estimate_motion(small.view(), small.view(), {}, m));
  EXPECT_FALSE(estimate_motion({}, a.view(), {}, m));
}

TEST(Luma, TakesGreyAndTheYOfYuyvAndAverages) {
  Pixels grey(PixelFormat::mono8, 8, 4, 3), yuyv(PixelFormat::yuyv, 8, 4);
  for (std::uint32_t y = 0; y < 4; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) {
      grey.row(y)[x] = yuyv.row(y)[2 * x] = static_cast<std::uint8_t>(10 * y + x);
      yuyv.row(y)[2 * x + 1] = 200;
    }
  Luma luma(8 * 4);
  for (const ImageView v : {grey.view(), yuyv.view()}) {
    ASSERT_TRUE(luma.take(v, 1));
    EXPECT_EQ(luma.view().row(3)[7], 37);
    ASSERT_TRUE(luma.take(v, 2));
    EXPECT_EQ(luma.view().width, 4u);
    EXPECT_EQ(luma.view().row(1)[2], 30);  // mean of 24 25 34 35 is 29.5
    ASSERT_TRUE(luma.take(v, 4));
    EXPECT_EQ(luma.view().row(0)[1], 21);  // mean of rows 0 to 3, columns 4 to 7 is 20.5
  }
  EXPECT_FALSE(luma.take(grey.view(), 3));
  EXPECT_TRUE(luma.empty());
  EXPECT_FALSE(luma.take(Pixels(PixelFormat::rgb8, 4, 4).view(), 1));
  EXPECT_FALSE(luma.take(Pixels(PixelFormat::mono8, 9, 4).view(), 1));
  EXPECT_FALSE(luma.take({}, 1));
}

TEST(TravelDetector, ShakingIsNotTravellingAndAFastPictureTravelsAtOnce) {
  TravelDetector detector;
  msg::MotionField field;
  field.moving = 1;
  for (int i = 0; i < 50; ++i) {
    field.speed_x_px = i % 2 ? 0.9 : -0.9;
    EXPECT_FALSE(detector.update(field, {})) << i;
  }
  field.speed_x_px = 0.6;  // slow and steady: after a while
  int frames = 1;
  while (!detector.update(field, {})) ASSERT_LT(++frames, 20);
  EXPECT_GE(frames, 4);
  detector.reset();
  field.speed_x_px = 3;
  EXPECT_TRUE(detector.update(field, {}));
  field.moving = 0;
  EXPECT_FALSE(detector.update(field, {}));
}

/// Real frames, when SINEW_DATA names a folder with them.
class RealFrames : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("SINEW_DATA");
    if (folder == nullptr || !std::filesystem::is_directory(folder))
      GTEST_SKIP() << "SINEW_DATA does not name a folder in the EuRoC form";
    std::string why;
    auto data = dataset::DatasetFolder::open(folder, why);
    ASSERT_TRUE(data) << why;
    if (data->images.empty()) GTEST_SKIP() << folder << " has no images";
    data_ = std::move(*data);
    const std::size_t frames = std::min<std::size_t>(40, data_.images.size());
    Luma older(1280 * 960), newer(1280 * 960);
    for (std::size_t i = 0; i < frames; ++i) {
      dataset::DecodedImage image;
      ASSERT_TRUE(data_.decode(data_.images[i], image, why)) << why;
      ASSERT_TRUE(newer.take({image.pixels.data(), image.width, image.height, image.width, image.format}, 1));
      msg::MotionField m;
      if (i > 0) {
        ASSERT_TRUE(estimate_motion(older.view(), newer.view(), {}, m));
        fields_.push_back(m);
      }
      older.swap(newer);
    }
  }
  dataset::DatasetFolder data_;
  std::vector<msg::MotionField> fields_;  // between frames i and i + 1
};

// EuRoC V1_01 begins with a vehicle on the ground whose motors start: it shakes, but does not move.
TEST_F(RealFrames, AVehicleThatStandsStillDoesNotTravelInAnyFrame) {
  TravelDetector detector;
  double largest = 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    EXPECT_FALSE(detector.update(fields_[i], {})) << i;
    largest = std::max(largest, std::hypot(fields_[i].speed_x_px, fields_[i].speed_y_px));
  }
  std::printf("%zu pairs of frames, shaken by up to %.2f px\n", fields_.size(), largest);
}

// The vehicle's rotation shakes the picture, and its gyro saw that too: two sensors, one motion.
TEST_F(RealFrames, TheShakingAgreesWithTheGyro) {
  if (data_.imu.empty()) GTEST_SKIP() << "no IMU samples beside the images";
  // Of EuRoC's VI sensor, cam0 (its sensor.yaml): focal length, and the camera's x and y axes in the IMU's frame.
  constexpr double kFocalPx = 458;
  constexpr double kXInImu[3] = {0.0149, 0.9996, -0.0258}, kYInImu[3] = {-0.9999, 0.0150, 0.0038};
  const auto rate = [&](std::int64_t from, std::int64_t to) {  // mean gyro about the camera's x and y axes
    double x = 0, y = 0, n = 0;
    for (const auto& s : data_.imu) {
      if (s.stamp.ns < from || s.stamp.ns >= to) continue;
      const double g[3] = {s.gyro_radps.x, s.gyro_radps.y, s.gyro_radps.z};
      for (int k = 0; k < 3; ++k) x += kXInImu[k] * g[k], y += kYInImu[k] * g[k];
      ++n;
    }
    return std::pair{x / n, y / n};
  };
  const auto bias = rate(data_.images[0].stamp_ns, data_.images[5].stamp_ns);  // the motors are still off
  double error = 0, size = 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const std::int64_t from = data_.images[i].stamp_ns, to = data_.images[i + 1].stamp_ns;
    const double dt = static_cast<double>(to - from) * 1e-9;
    const auto turn = rate(from, to);
    // Turning about x (right axis) moves the picture down, about y (down axis) to the left.
    const double x_px = -(turn.second - bias.second) * dt * kFocalPx, y_px = (turn.first - bias.first) * dt * kFocalPx;
    error += std::pow(fields_[i].speed_x_px - x_px, 2) + std::pow(fields_[i].speed_y_px - y_px, 2);
    size += x_px * x_px + y_px * y_px;
  }
  const double n = static_cast<double>(fields_.size());
  std::printf("shaking %.3f px RMS by the gyro, the motion field differs by %.3f px RMS\n", std::sqrt(size / n),
              std::sqrt(error / n));
  EXPECT_LT(error, 0.35 * size);
}

}  // namespace
}  // namespace sinew::vision::motion_grid_test
