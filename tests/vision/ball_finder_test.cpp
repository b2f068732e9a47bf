// Discs painted with soft edges, whose places are known to a fraction of a pixel.
#include "vision/ball_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "images.hpp"
#include "msg/image_buffer.hpp"
#include "rt/exec/module_rig.hpp"
#include "vision/ball_detector.hpp"

namespace sinew::vision::ball_finder_test {
namespace {

using namespace std::chrono_literals;
using msg::PixelFormat;

constexpr Rgb kOrange{235, 95, 20}, kGround{120, 118, 110}, kWhite{240, 240, 236}, kViolet{110, 70, 140};

struct Disc {
  double x = 0, y = 0, radius = 0;
  Rgb colour = kOrange;
};

/// How much of a pixel lies in the disc, by 8 x 8 samples.
double share(const Disc& d, double x, double y) {
  int in = 0;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) {
      const double dx = x - 0.4375 + i / 8.0 - d.x, dy = y - 0.4375 + j / 8.0 - d.y;
      in += dx * dx + dy * dy < d.radius * d.radius;
    }
  return in / 64.0;
}

Rgb mix(const Rgb& a, const Rgb& b, double s) {
  const auto one = [s](int p, int q) { return static_cast<int>(std::lround(p + s * (q - p))); };
  return {one(a.r, b.r), one(a.g, b.g), one(a.b, b.b)};
}

using Paint = std::function<Rgb(double x, double y, Rgb under)>;

test::Pixels picture(std::uint32_t width, std::uint32_t height, const std::vector<Disc>& discs,
                     const Paint& over = nullptr, int noise = 3) {
  test::Pixels p(PixelFormat::yuyv, width, height);
  test::paint_yuyv(p.bytes().data(), width, height, [&](std::uint32_t x, std::uint32_t y) {
    Rgb c = kGround;
    for (const Disc& d : discs)
      if (std::fabs(x - d.x) < d.radius + 2 && std::fabs(y - d.y) < d.radius + 2) c = mix(c, d.colour, share(d, x, y));
    return over ? over(x, y, c) : c;
  });
  math::Random random(7);
  for (auto& v : p.bytes())
    v = static_cast<std::uint8_t>(
        std::clamp(v + static_cast<int>(random.below(static_cast<std::uint32_t>(2 * noise + 1))) - noise, 0, 255));
  return p;
}

/// Through a long lens, which draws a ball round everywhere.
BallImage find(const test::Pixels& p) {
  const ImageView v = p.view();
  return BallFinder({}, {.colours = 1, .min_area_px = 12}).find(v, Pinhole::from_fov(0.1, v.width, v.height));
}

class Sizes : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(Sizes, CentreAndRadiusAreFinerThanAPixel) {
  const auto [width, height] = GetParam();
  math::Random random(3);
  double worst = 0, sum2 = 0;
  int n = 0;
  for (const double radius : {4.0, 6.5, 10.0, 16.0, 30.0, 55.0})
    for (int i = 0; i < 8; ++i) {
      const Disc d{random.uniform(radius + 2, width - radius - 3), random.uniform(radius + 2, height - radius - 3),
                   radius};
      const BallImage b = find(picture(width, height, {d}));
      ASSERT_TRUE(b.found) << radius << " at " << d.x << ' ' << d.y;
      const double off = std::hypot(b.u_px - d.x, b.v_px - d.y);
      worst = std::max(worst, off);
      sum2 += off * off;
      ++n;
      EXPECT_NEAR(b.radius_px, radius, 0.6 + 0.02 * radius);
      EXPECT_GT(b.confidence, 0.2) << radius;
    }
  EXPECT_LT(worst, 0.6);
  EXPECT_LT(std::sqrt(sum2 / n), 0.3);
}
INSTANTIATE_TEST_SUITE_P(BallFinder, Sizes, testing::Values(std::pair{320u, 240u}, std::pair{640u, 480u}),
                         [](const auto& p) { return std::to_string(p.param.first); });

TEST(BallFinder, IsFoundWhereTheImageCutsIt) {
  for (const Disc& d : {Disc{3, 120, 14}, Disc{317, 100, 14}, Disc{160, 2, 14}, Disc{100, 238, 14}}) {
    const BallImage b = find(picture(320, 240, {d}));
    ASSERT_TRUE(b.found) << d.x << ' ' << d.y;
    EXPECT_NEAR(b.u_px, d.x, 1.5);
    EXPECT_NEAR(b.v_px, d.y, 1.5);
  }
}

TEST(BallFinder, TheEndOfAPlankAtTheBorderIsNoSmallBall) {
  for (const unsigned scale : {1u, 2u}) {  // seed 611 of the desk head lost its ball to one of 6.5 px
    const double v = 237.0 * scale, r = 6.6 * scale;
    EXPECT_FALSE(find(picture(320 * scale, 240 * scale, {{160.0 * scale, v, r}})).found) << scale;
    EXPECT_TRUE(find(picture(320 * scale, 240 * scale, {{160.0 * scale, 120.0 * scale, r}})).found) << scale;
  }
}

TEST(BallFinder, ABrightSpotOnItDoesNotMoveIt) {
  const Disc ball{150.3, 99.6, 18}, spot{146, 93, 4.5, kWhite};
  const BallImage b = find(picture(320, 240, {ball, spot}));
  ASSERT_TRUE(b.found);
  EXPECT_NEAR(b.u_px, ball.x, 0.4);
  EXPECT_NEAR(b.v_px, ball.y, 0.4);
}

TEST(BallFinder, HalfHiddenItIsStillWhereItsRestSaysOrNotThere) {
  const Disc ball{150, 100, 18};
  for (double edge = 132; edge < 168; edge += 3) {
    const BallImage b =
        find(picture(320, 240, {ball}, [&](double x, double, Rgb under) { return x > edge ? kWhite : under; }));
    if (!b.found) continue;
    EXPECT_NEAR(b.v_px, ball.y, 2.5) << edge;
    EXPECT_NEAR(b.u_px, ball.x, 9.5) << edge;
  }
  const auto quarter = find(picture(320, 240, {ball}, [](double x, double, Rgb u) { return x > 162 ? kWhite : u; }));
  EXPECT_TRUE(quarter.found) << "three quarters of it are enough";
}

TEST(BallFinder, OfSeveralTheLargestIsTaken) {
  const BallImage b = find(picture(320, 240, {{60, 60, 9}, {200, 150, 15}, {270, 40, 12}}));
  ASSERT_TRUE(b.found);
  EXPECT_NEAR(b.u_px, 200, 0.5);
  EXPECT_EQ(b.blobs, 3u);
}

TEST(BallFinder, WhatHasTheColourButIsNotRoundIsNoBall) {
  const auto only = [](const Paint& paint) { return find(picture(320, 240, {}, paint)); };
  const auto box = [](double x0, double x1, double y0, double y1) {
    return [=](double x, double y, Rgb u) { return x >= x0 && x < x1 && y >= y0 && y < y1 ? kOrange : u; };
  };
  EXPECT_FALSE(only(box(100, 180, 100, 112)).found) << "a plank";
  EXPECT_FALSE(only(box(100, 112, 60, 160)).found) << "a post";
  EXPECT_FALSE(only(box(100, 150, 60, 110)).found) << "a box";
  EXPECT_FALSE(only(box(0, 320, 150, 240)).found) << "the floor";
  EXPECT_FALSE(only([](double x, double y, Rgb u) {
                 const double dx = (x - 160) / 40, dy = (y - 120) / 14;
                 return dx * dx + dy * dy < 1 ? kOrange : u;
               }).found)
      << "a rugby ball";
  EXPECT_FALSE(only([](double x, double y, Rgb u) {
                 const double r = std::hypot(x - 160, y - 120);
                 return r < 40 && r > 32 ? kOrange : u;
               }).found)
      << "a ring";
}

TEST(BallFinder, WhatIsRoundButHasAnotherColourIsNoBall) {
  EXPECT_FALSE(find(picture(320, 240, {{160, 120, 20, kViolet}})).found);
  EXPECT_FALSE(find(picture(320, 240, {{160, 120, 20, {205, 185, 55}}})).found) << "yellow";
  EXPECT_FALSE(find(picture(320, 240, {{160, 120, 20, {200, 20, 30}}})).found) << "red";
}

TEST(BallFinder, KeepsItsColourInHalfTheLight) {
  const Disc dim{160, 120, 12, {150, 60, 12}};
  EXPECT_TRUE(find(picture(320, 240, {dim})).found);
}

TEST(BallFinder, NoiseIsNoBallAndCostsBoundedMemory) {
  test::Pixels p(PixelFormat::yuyv, 640, 480);
  test::fill_noise(p.bytes().data(), p.bytes().size(), 5);
  EXPECT_FALSE(find(p).found);
  EXPECT_FALSE(find(picture(320, 240, {})).found);
}

TEST(BallFinder, ImagesOfAnotherFormatHaveNoBall) {
  test::Pixels grey(PixelFormat::mono8, 320, 240);
  EXPECT_FALSE(find(grey).found);
}

// ---- the module

msg::ImageBuffer message(const test::Pixels& p, msg::Time stamp) {
  const ImageView v = p.view();
  msg::ImageBuffer image(v.format, v.width, v.height);
  std::memcpy(image->pixels(), v.data, std::size_t{v.stride} * v.height);
  image->stamp = stamp;
  return image;
}

TEST(BallDetector, SaysWhereTheBallIsAndHowFarAway) {
  BallDetector detector;
  rt::ModuleRig rig(detector);
  // 1.5 m away, 210 px of focal length: 70 px to the right of the middle is atan(1/3).
  rig.put_image("image", message(picture(320, 240, {{159.5 + 70, 119.5, 9.8}}), msg::Time{5'000'000}));
  ASSERT_EQ(rig.step(msg::Time{9'000'000}, 33ms), rt::StepStatus::ok);
  const auto* s = rig.get<msg::BallSighting>("sighting");
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(s->found, 1u);
  EXPECT_EQ(s->stamp, msg::Time{5'000'000});
  EXPECT_NEAR(std::atan2(s->direction_optical.x, s->direction_optical.z), std::atan(1.0 / 3), 0.003);
  EXPECT_NEAR(s->direction_optical.y, 0, 0.003);
  EXPECT_NEAR(s->range_m, 0.07 / std::sin(s->angular_radius_rad), 1e-12);
  // Half-way between what a disc of 9.8 px means along the radius and across it.
  EXPECT_NEAR(s->angular_radius_rad, 9.8 / 210 * std::pow(std::cos(std::atan(1.0 / 3)), 1.5), 0.004);
}

TEST(BallDetector, WhatWouldBeTooFarAwayIsNoBall) {
  BallDetector detector;
  rt::ModuleRig rig(detector);
  rig.set("range_max_m", 3.0);
  rig.put_image("image", message(picture(320, 240, {{100, 100, 4}}), msg::Time{1}));  // 3.7 m
  ASSERT_EQ(rig.step(msg::Time{2}, 33ms), rt::StepStatus::ok);
  EXPECT_EQ(rig.get<msg::BallSighting>("sighting")->found, 0u);
  rig.put_image("image", message(picture(320, 240, {{100, 100, 6}}), msg::Time{3}));
  ASSERT_EQ(rig.step(msg::Time{4}, 33ms), rt::StepStatus::ok);
  EXPECT_EQ(rig.get<msg::BallSighting>("sighting")->found, 1u);
}

TEST(BallDetector, AnImageWithoutABallIsASightingOfNothing) {
  BallDetector detector;
  rt::ModuleRig rig(detector);
  rig.put_image("image", message(picture(320, 240, {}), msg::Time{1}));
  ASSERT_EQ(rig.step(msg::Time{2}, 33ms), rt::StepStatus::ok);
  const auto* s = rig.get<msg::BallSighting>("sighting");
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(s->found, 0u);
  EXPECT_TRUE(math::is_nan(s->range_m));
}

TEST(BallDetector, OldAndUselessImagesGiveNoMessage) {
  BallDetector detector;
  rt::ModuleRig rig(detector);
  EXPECT_EQ(rig.step(msg::Time{1}, 33ms), rt::StepStatus::stale);
  rig.put_image("image", message(picture(320, 240, {}), msg::Time{1}));
  EXPECT_EQ(rig.step(msg::Time{2}, 33ms), rt::StepStatus::ok);
  EXPECT_EQ(rig.step(msg::Time{3}, 33ms), rt::StepStatus::stale) << "the same image";
  rig.put_image("image", message(test::Pixels(PixelFormat::mono8, 320, 240), msg::Time{4}));
  EXPECT_EQ(rig.step(msg::Time{5}, 33ms), rt::StepStatus::fault);
}

}  // namespace
}  // namespace sinew::vision::ball_finder_test
