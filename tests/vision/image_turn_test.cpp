#include "vision/image_turn.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "math/random.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::vision::image_turn_test {
namespace {

using math::Quat;
using math::Vec3;

constexpr double kFov = 1.0382921838;  // 59.5 degrees from top to bottom
constexpr std::uint32_t kWidth = 320, kHeight = 240;

/// A room whose walls are painted with waves: grey as a function of the direction, in the world.
double painted(const Vec3& d) {
  return 128 + 35 * std::sin(9 * d.x + 4 * d.y) + 30 * std::sin(11 * d.y - 5 * d.z + 1) +
         25 * std::sin(13 * d.z + 7 * d.x);
}

class Scene {
 public:
  explicit Scene(double noise = 0, std::uint64_t seed = 1) : noise_(noise), random_(seed, 1) {}
  msg::ImageBuffer seen(const Quat& q_world_optical, std::uint32_t width = kWidth, std::uint32_t height = kHeight) {
    const Pinhole camera = Pinhole::from_fov(kFov, width, height);
    msg::ImageBuffer image(msg::PixelFormat::mono8, width, height);
    for (std::uint32_t v = 0; v < height; ++v)
      for (std::uint32_t u = 0; u < width; ++u) {
        const double grey = painted(q_world_optical.rotate(Vec3(camera.direction(u, v)))) + noise_ * random_.normal();
        image->row(v)[u] = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
      }
    return image;
  }

 private:
  double noise_;
  math::Random random_;
};

double error_rad(const std::optional<ImageTurn::Turn>& turn, const Vec3& truth) {
  return turn ? norm(turn->rotation_rad - truth) : 9;
}

TEST(ImageTurn, TurnBetweenTwoPicturesIsFoundAboutEachAxis) {
  const Quat q = Quat::exp({0.3, -0.4, 0.1});
  for (const Vec3& by : {Vec3{0.02, 0, 0}, Vec3{0, -0.03, 0}, Vec3{0, 0, 0.04}, Vec3{-0.01, 0.02, 0.03}, Vec3{}}) {
    Scene scene(1.5);
    ImageTurn turns(kFov);
    EXPECT_FALSE(turns.add(view(*scene.seen(q)))) << "the first one has none before it";
    EXPECT_LT(error_rad(turns.add(view(*scene.seen(q * Quat::exp(by)))), by), 3e-4)
        << by.x << ' ' << by.y << ' ' << by.z;
  }
}

TEST(ImageTurn, SmallTurnsAddUpWithoutDrift) {
  Scene scene(1.5);
  ImageTurn turns(kFov);
  Vec3 sum;
  const Vec3 by{0.004, -0.003, 0.002};
  Quat q;
  for (int i = 0; i <= 40; ++i, q = q * Quat::exp(by))
    if (const auto turn = turns.add(view(*scene.seen(q)))) sum += turn->rotation_rad;
  EXPECT_LT(norm(sum - 40 * by), 0.003);
}

TEST(ImageTurn, OtherBrightnessIsNoTurn) {
  Scene scene;
  ImageTurn turns(kFov);
  const Vec3 by{0.01, 0.01, -0.02};
  turns.add(view(*scene.seen({})));
  auto second = scene.seen(Quat::exp(by));
  for (std::uint32_t i = 0; i < second->bulk_used(); ++i)
    second->pixels()[i] = static_cast<std::uint8_t>(std::min(255, second->pixels()[i] + 12));
  EXPECT_LT(error_rad(turns.add(view(*second)), by), 1e-3);
}

TEST(ImageTurn, SomethingThatMovesThroughThePictureCountsLittle) {
  Scene scene;
  ImageTurn turns(kFov);
  const Vec3 by{0.01, -0.015, 0.01};
  const auto with_ball = [&](const Quat& q, std::uint32_t x) {
    auto image = scene.seen(q);
    for (std::uint32_t v = 80; v < 130; ++v)
      for (std::uint32_t u = x; u < x + 50; ++u) image->row(v)[u] = 255;
    return image;
  };
  turns.add(view(*with_ball({}, 60)));
  EXPECT_LT(error_rad(turns.add(view(*with_ball(Quat::exp(by), 100))), by), 2e-3);
}

TEST(ImageTurn, WithoutTextureThereIsNoTurn) {
  ImageTurn turns(kFov);
  msg::ImageBuffer blank(msg::PixelFormat::mono8, kWidth, kHeight);
  turns.add(view(*blank));
  EXPECT_FALSE(turns.add(view(*blank)));
}

TEST(ImageTurn, PicturesOfDifferentSceneHaveNoneOrSayHowLittleTheyAgree) {
  Scene scene;
  ImageTurn turns(kFov);
  turns.add(view(*scene.seen({})));
  const auto turn = turns.add(view(*scene.seen(Quat::exp({0, 1.5, 0}))));
  EXPECT_TRUE(!turn || turn->disagreement > 5);
}

TEST(ImageTurn, AnotherSizeOrFormatBeginsAnew) {
  Scene scene;
  ImageTurn turns(kFov);
  turns.add(view(*scene.seen({})));
  EXPECT_FALSE(turns.add(view(*scene.seen({}, 160, 120))));
  EXPECT_TRUE(turns.add(view(*scene.seen({}, 160, 120))));
  msg::ImageBuffer colour(msg::PixelFormat::rgb8, 160, 120);
  EXPECT_FALSE(turns.add(view(*colour)));
  EXPECT_FALSE(turns.add(view(*scene.seen({}, 160, 120))));
}

}  // namespace
}  // namespace sinew::vision::image_turn_test
