#include "vision/ground_shift.hpp"

#include <gtest/gtest.h>
#include <cstring>

#include <cmath>

#include "images.hpp"
#include "msg/image_buffer.hpp"
#include "rt/exec/module_rig.hpp"
#include "vision/ground_motion.hpp"
#include "vision/luma.hpp"

namespace sinew::vision::ground_shift_test {
namespace {

using msg::PixelFormat;
using msg::Time;
using namespace std::chrono_literals;

/// A texture of many waves up to a shortest one, seen from a place; seen again from another place it has moved exactly.
struct Texture {
  double shortest_px = 6, contrast = 20, mean = 128;
  std::uint64_t seed = 1;

  double grey(double x, double y) const {
    math::Random random(seed);
    double sum = 0;
    constexpr int kWaves = 24;
    for (int i = 0; i < kWaves; ++i) {
      const double angle = random.uniform(0, 2 * M_PI), phase = random.uniform(0, 2 * M_PI);
      const double k = 2 * M_PI / (shortest_px * (1 + 3 * random.uniform()));
      sum += std::cos(k * (std::cos(angle) * x + std::sin(angle) * y) + phase);
    }
    return mean + contrast * sum * std::sqrt(2.0 / kWaves);
  }
  test::Pixels seen(double right_px, double down_px, std::uint32_t width = 40, std::uint32_t height = 30) const {
    test::Pixels p(PixelFormat::mono8, width, height);
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x)
        p.row(y)[x] = static_cast<std::uint8_t>(std::clamp(grey(x - right_px, y - down_px) + 0.5, 0.0, 255.0));
    return p;
  }
};

ShiftReading read(const Texture& t, double right_px, double down_px, ShiftBy by) {
  std::vector<std::uint8_t> scratch(2 * 40 * 30);
  const auto a = t.seen(0, 0), b = t.seen(right_px, down_px);
  return read_shift(a.view(), b.view(), by, 0.3, scratch).value();
}

TEST(GroundShift, TheGradientReadsPixelsWhateverContrastBrightnessAndFineness) {
  for (const Texture t : {Texture{}, Texture{.contrast = 6}, Texture{.contrast = 35, .mean = 100},
                          Texture{.shortest_px = 4, .seed = 2}, Texture{.shortest_px = 12, .seed = 3}})
    for (const double down_px : {0.2, 0.66, 1.0}) {
      const ShiftReading r = read(t, -0.15, down_px, ShiftBy::gradient);
      EXPECT_NEAR(r.y, down_px, 0.05 * down_px + 0.02) << t.shortest_px << ' ' << t.contrast;
      EXPECT_NEAR(r.x, -0.15, 0.04);
      EXPECT_TRUE(r.seen);
    }
}

TEST(GroundShift, OneQuotientReadsFineTextureTooFast) {
  const Texture fine{.shortest_px = 3};
  const double once = read_shift(fine.seen(0, 0).view(), fine.seen(0, 0.66).view(), ShiftBy::gradient, 0.3)->y;
  EXPECT_GT(once, 1.15 * 0.66);
  EXPECT_NEAR(read(fine, 0, 0.66, ShiftBy::gradient).y, 0.66, 0.06);
}

TEST(GroundShift, AStrongLineThatMovesOtherwiseDoesNotDecideTheGradient) {
  const Texture t{.contrast = 6};
  auto a = t.seen(0, 0), b = t.seen(0, 0.66);
  for (std::uint32_t y = 0; y < 30; ++y)  // in one of four columns of parts
    for (std::uint32_t x = 24; x < 28; ++x) a.row(y)[x] = b.row(y)[x] = y % 8 < 4 ? 20 : 220;
  std::vector<std::uint8_t> scratch(2 * 40 * 30);
  EXPECT_NEAR(read_shift(a.view(), b.view(), ShiftBy::gradient, 0.3, scratch)->y, 0.66, 0.1);
  EXPECT_LT(read_shift(a.view(), b.view(), ShiftBy::gradient, 0.3)->y, 0.2);  // the whole picture's quotient
}

TEST(GroundShift, TheRawReadingGrowsWithTheContrastSquaredAndTheNormalisedOneDoesNot) {
  const Texture weak{.contrast = 10}, strong{.contrast = 30};
  EXPECT_NEAR(read(strong, 0, 0.5, ShiftBy::raw).y / read(weak, 0, 0.5, ShiftBy::raw).y, 9, 2.5);
  EXPECT_NEAR(read(strong, 0, 0.5, ShiftBy::contrast).y / read(weak, 0, 0.5, ShiftBy::contrast).y, 1, 0.05);
}

TEST(GroundShift, BeyondItsPeakTheCorrelatorReadsFastMotionAsSlow) {
  const Texture t{.shortest_px = 4};
  const double peak = read(t, 0, 1.5, ShiftBy::contrast).y;
  EXPECT_GT(peak, 1.5 * read(t, 0, 0.5, ShiftBy::contrast).y);
  double least = peak;
  for (const double fast_px : {4.0, 5.0, 6.0, 7.0}) least = std::min(least, read(t, 0, fast_px, ShiftBy::contrast).y);
  EXPECT_LT(least, 0.4 * peak);
}

TEST(GroundShift, AnEvenPictureIsNotSeen) { EXPECT_FALSE(read({.contrast = 0.2}, 0, 0.5, ShiftBy::gradient).seen); }

TEST(GroundShift, PicturesOfDifferentOrTinySizeGiveNothing) {
  const Texture t;
  EXPECT_FALSE(read_shift(t.seen(0, 0).view(), t.seen(0, 0, 40, 29).view(), ShiftBy::gradient, 1));
  EXPECT_FALSE(read_shift(t.seen(0, 0, 7, 30).view(), t.seen(0, 0, 7, 30).view(), ShiftBy::raw, 1));
  EXPECT_FALSE(read_shift({}, t.seen(0, 0).view(), ShiftBy::raw, 1));
}

TEST(GroundShift, TheBinFollowsFromTheWantedMotion) {
  constexpr double kFrame_s = 1.0 / 30;
  EXPECT_EQ(bin_for(1, kFrame_s, 160, 0.7), 8u);     // altURI's numbers: 5.3 pixels a frame
  EXPECT_EQ(bin_for(0.75, kFrame_s, 105, 0.7), 4u);  // robots/terrain: 2.6
  EXPECT_EQ(bin_for(0.19, kFrame_s, 105, 0.7), 1u);
  EXPECT_EQ(bin_for(10, kFrame_s, 420, 0.7), 8u);  // no bin is enough
}

TEST(Luma, AveragesSquaresOfEightPixelsOfEitherFormat) {
  test::Pixels mono(PixelFormat::mono8, 75, 17, 3), yuyv(PixelFormat::yuyv, 74, 17, 6);
  test::fill_noise(mono.bytes().data(), mono.bytes().size(), 1);
  test::fill_noise(yuyv.bytes().data(), yuyv.bytes().size(), 2);
  for (const bool is_mono : {true, false})
    for (const std::uint32_t bin : {1u, 2u, 4u, 8u}) {
      const ImageView image = is_mono ? mono.view() : yuyv.view();
      Luma luma(std::size_t{image.width} * image.height);
      ASSERT_TRUE(luma.take(image, bin));
      const ImageView small = luma.view();
      ASSERT_EQ(small.width, image.width / bin);
      ASSERT_EQ(small.height, image.height / bin);
      for (std::uint32_t y = 0; y < small.height; ++y)
        for (std::uint32_t x = 0; x < small.width; ++x) {
          std::uint32_t sum = bin * bin / 2;
          for (std::uint32_t v = 0; v < bin; ++v)
            for (std::uint32_t u = 0; u < bin; ++u) sum += image.row(y * bin + v)[(x * bin + u) * (is_mono ? 1 : 2)];
          ASSERT_EQ(small.row(y)[x], sum / (bin * bin)) << bin << ' ' << x << ' ' << y;
        }
    }
  Luma luma(75 * 17);
  EXPECT_FALSE(luma.take(mono.view(), 3));
  EXPECT_FALSE(luma.take(mono.view(), 16));
}

TEST(Luma, VectorsAndTheRestOfARowGiveTheBytesOfTheScalarKernel) {
  for (const std::uint32_t width : {2u, 62u, 64u, 160u, 246u, 640u})
    for (const bool is_mono : {true, false})
      for (const std::uint32_t bin : {1u, 2u, 4u, 8u}) {
        test::Pixels pixels(is_mono ? PixelFormat::mono8 : PixelFormat::yuyv, width, 16, is_mono ? 5 : 6);
        test::fill_noise(pixels.bytes().data(), pixels.bytes().size(), width);
        Luma scalar(640 * 16), best(640 * 16);
        ASSERT_EQ(scalar.take(pixels.view(), bin, Simd::scalar), width >= bin);
        ASSERT_EQ(best.take(pixels.view(), bin), width >= bin);
        for (std::uint32_t y = 0; y < scalar.view().height; ++y)
          ASSERT_EQ(std::memcmp(scalar.view().row(y), best.view().row(y), scalar.view().width), 0)
              << width << ' ' << bin << ' ' << is_mono << ' ' << y;
      }
}

constexpr double kFocal_px = 105;  // of 160x120 with the default field of view

msg::ImageBuffer camera(const Texture& t, double right_px, double down_px, Time stamp) {
  const test::Pixels p = t.seen(right_px, down_px, 160, 120);
  msg::ImageBuffer image(PixelFormat::mono8, 160, 120);
  for (std::uint32_t y = 0; y < 120; ++y) std::copy_n(p.view().row(y), 160, image->row(y));
  image->stamp = stamp;
  return image;
}

struct Ground {
  GroundMotion detector;
  rt::ModuleRig rig{detector};
  Texture texture{.shortest_px = 24};
};

TEST(GroundMotion, SaysHowFastTheGroundPassesForwardAndToTheLeft) {
  Ground g;
  g.rig.put_image("image", camera(g.texture, 0, 0, Time{1'000'000'000}));
  EXPECT_EQ(g.rig.step(Time{1'010'000'000}, 33ms), rt::StepStatus::stale);
  // The ground goes down in the picture and to the right: the vehicle travels forward and to the left.
  g.rig.put_image("image", camera(g.texture, 0.8, 2.4, Time{1'033'333'333}));
  ASSERT_EQ(g.rig.step(Time{1'040'000'000}, 33ms), rt::StepStatus::ok);
  const auto* m = g.rig.get<msg::GroundMotion>("motion");
  ASSERT_NE(m, nullptr);
  EXPECT_EQ(m->bin, 4u);
  EXPECT_EQ(m->interval_ns, 33'333'333);
  EXPECT_NEAR(m->forward_radps, 2.4 / kFocal_px * 30, 0.03);
  EXPECT_NEAR(m->left_radps, 0.8 / kFocal_px * 30, 0.03);
}

TEST(GroundMotion, TakesTheVehiclesOwnTurningOff) {
  Ground g;
  // Nose down by 0.3 rad/s: about base y. The whole ground goes up in the picture, by f * turn in the middle and a
  // little more on the average.
  for (std::int64_t ms = 990; ms <= 1040; ++ms) {
    msg::NavState s;
    s.stamp = Time{ms * 1'000'000};
    s.gyro_radps = {0, 0.3, 0};
    g.rig.put("state", s);
  }
  const PixelShift turned = shift_of_turn({-0.01, 0, 0}, 160, 120, kFocal_px);
  EXPECT_NEAR(turned.y_px, -1.05 * (1 + 120.0 * 120 / (12 * 105 * 105)), 1e-9);
  g.rig.put_image("image", camera(g.texture, 0, 0, Time{1'000'000'000}));
  EXPECT_EQ(g.rig.step(Time{1'001'000'000}, 33ms), rt::StepStatus::stale);
  g.rig.put_image("image", camera(g.texture, 0, turned.y_px, Time{1'033'333'333}));
  ASSERT_EQ(g.rig.step(Time{1'040'000'000}, 33ms), rt::StepStatus::ok);
  const auto* m = g.rig.get<msg::GroundMotion>("motion");
  EXPECT_NEAR(m->turn_forward_px, turned.y_px / 4, 0.005);
  EXPECT_NEAR(m->forward_radps, 0, 0.02);
}

TEST(GroundMotion, ShowsTheMotionAsAPictureOfTheCamerasSize) {
  Ground g;
  g.rig.put_image("image", camera(g.texture, 0, 0, Time{1'000'000'000}));
  EXPECT_EQ(g.rig.step(Time{1'010'000'000}, 33ms), rt::StepStatus::stale);
  g.rig.put_image("image", camera(g.texture, 0, 2.4, Time{1'033'333'333}));
  ASSERT_EQ(g.rig.step(Time{1'040'000'000}, 33ms), rt::StepStatus::ok);
  const auto* p = g.rig.get<msg::Image>("picture");
  ASSERT_NE(p, nullptr);
  EXPECT_EQ(p->format, PixelFormat::rgb8);
  EXPECT_EQ(p->width, 160u);
  EXPECT_EQ(p->height, 120u);
  EXPECT_EQ(p->stamp, Time{1'033'333'333});
  EXPECT_TRUE(std::equal(p->row(0), p->row(0) + p->stride, p->row(3)));  // a bin is a square
}

TEST(GroundMotion, UselessImagesAreFaultsAndUnknownDetectorsAreRefused) {
  Ground g;
  g.rig.put_image("image", msg::ImageBuffer(PixelFormat::rgb8, 160, 120));
  EXPECT_EQ(g.rig.step(Time{1}, 33ms), rt::StepStatus::fault);
  g.rig.put_image("image", camera(g.texture, 0, 0, Time{10}));
  EXPECT_EQ(g.rig.step(Time{11}, 33ms), rt::StepStatus::stale);
  g.rig.put_image("image", camera(g.texture, 0, 0, Time{10}));  // not after the last one
  EXPECT_EQ(g.rig.step(Time{12}, 33ms), rt::StepStatus::fault);
  EXPECT_FALSE(shift_by("optical"));
  EXPECT_EQ(shift_by("raw"), ShiftBy::raw);
}

}  // namespace
}  // namespace sinew::vision::ground_shift_test
