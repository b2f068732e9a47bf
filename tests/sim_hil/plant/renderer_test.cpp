// The picture of the downward camera: is it there, is everything in its place, is it the same every time?
#include "sim_hil/plant/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "robots/quad/world/vehicle.hpp"
#include "robots/robot_kind.hpp"
#include "sim_hil/plant/pixels.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::plant::renderer_test {
namespace {

std::string_view room_of(std::string_view world) {
  static const auto all = robots::all_worlds();
  for (const auto& type : all)
    if (type->info.name == world) return type->room_xml;
  return {};
}

constexpr std::uint32_t kWidth = 320, kHeight = 240;
constexpr double kFocal = kFocalPerHeight * kHeight;

class PlantRenderer : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string why;
    auto made = Renderer::create({kWidth, kHeight, false, room_of("quad")}, why);
    ASSERT_TRUE(made) << why;
    renderer_ = std::move(*made);
  }
  static void TearDownTestSuite() { renderer_.reset(); }

  static std::vector<std::uint8_t> look(const msg::Vec3& base, const msg::Quat& q = {}) {
    std::vector<std::uint8_t> image(kWidth * kHeight * 2);
    const CameraPose pose{add(base, Rotation(q).apply(kCameraPBase)), mul(q, kCameraQBaseOptical)};
    renderer_->camera_view(pose, msg::PixelFormat::yuyv, image.data());
    return image;
  }
  static std::unique_ptr<Renderer> renderer_;
};

std::unique_ptr<Renderer> PlantRenderer::renderer_;

struct Blob {
  double u = 0, v = 0, left = 1e9, right = -1;
  int pixels = 0;
};

/// Pixels with the pad's chroma, as docs/sinew-sim.md gives it.
Blob find_orange(const std::vector<std::uint8_t>& yuyv) {
  Blob b;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; x += 2) {
      const std::uint8_t* p = &yuyv[(y * kWidth + x) * 2];
      if (p[1] > 100 || p[3] < 185) continue;
      b.u += x + 0.5, b.v += y;
      b.left = std::min<double>(b.left, x), b.right = std::max<double>(b.right, x + 1);
      ++b.pixels;
    }
  if (b.pixels > 0) b.u /= b.pixels, b.v /= b.pixels;
  return b;
}

TEST_F(PlantRenderer, FramesAreNeitherBlackNorUniform) {
  for (const double z : {0.3, 1.0, 3.0}) {
    const auto image = look({1.2, 0.9, z});
    double sum = 0, sum2 = 0;
    for (std::size_t i = 0; i < image.size(); i += 2) sum += image[i], sum2 += double{1} * image[i] * image[i];
    const double n = static_cast<double>(image.size()) / 2, mean = sum / n;
    EXPECT_GT(mean, 60) << "at " << z;
    EXPECT_LT(mean, 200) << "at " << z;
    EXPECT_GT(std::sqrt(sum2 / n - mean * mean), 15) << "at " << z;
  }
}

TEST_F(PlantRenderer, PadIsCentredAndOfItsSizeWhenHoveringAboveIt) {
  const Blob b = find_orange(look({0, 0, 1.5}));
  EXPECT_NEAR(b.u, (kWidth - 1) / 2.0, 1.0);
  EXPECT_NEAR(b.v, (kHeight - 1) / 2.0, 1.0);
  const double radius = kFocal * kPadRadius / (1.5 + kCameraPBase.z);
  EXPECT_NEAR((b.right - b.left) / 2, radius, 2.5);  // mixed pixels at the edge are not orange
}

TEST_F(PlantRenderer, ForwardIsUpAndLeftIsLeftInTheImage) {
  const double shift = kFocal * 0.3 / (1.5 + kCameraPBase.z);
  Blob b = find_orange(look({0.3, 0, 1.5}));  // the pad is behind the vehicle
  EXPECT_NEAR(b.v, (kHeight - 1) / 2.0 + shift, 1.5);
  EXPECT_NEAR(b.u, (kWidth - 1) / 2.0, 1.5);
  b = find_orange(look({0, -0.3, 1.5}));  // the pad is to the left
  EXPECT_NEAR(b.u, (kWidth - 1) / 2.0 - shift, 1.5);
  EXPECT_NEAR(b.v, (kHeight - 1) / 2.0, 1.5);
  const double turn = std::sqrt(0.5);
  b = find_orange(look({0.3, 0, 1.5}, {turn, 0, 0, turn}));  // heading +y, the pad is to the left
  EXPECT_NEAR(b.u, (kWidth - 1) / 2.0 - shift, 1.5);
  EXPECT_NEAR(b.v, (kHeight - 1) / 2.0, 1.5);
}

TEST_F(PlantRenderer, NothingElseInTheRoomHasThePadsColour) {
  for (double x = -3; x <= 3; x += 1.5)
    for (double y = -3; y <= 3; y += 1.5) {
      if (x == 0 && y == 0) continue;
      const Blob b = find_orange(look({x, y, 0.9}));  // sees 0.7 m to each side
      EXPECT_LE(b.pixels, 2) << "at " << x << ", " << y;
    }
}

TEST_F(PlantRenderer, SameViewGivesTheSameBytesAlsoFromAnotherRenderer) {
  const auto first = look({0.4, 0.2, 1.1}), other = look({0.1, 0.1, 2.0});
  EXPECT_EQ(first, look({0.4, 0.2, 1.1}));
  EXPECT_NE(first, other);
  renderer_.reset();  // one context per thread
  SetUpTestSuite();
  EXPECT_EQ(first, look({0.4, 0.2, 1.1}));
}

TEST_F(PlantRenderer, DrawsInEveryRoomAlsoTheSmallestPictures) {
  renderer_.reset();  // one context per thread
  for (const char* world : {"quad", "desk_head"})
    for (const bool picture : {false, true}) {
      std::string why;
      EXPECT_TRUE(Renderer::create({16, 16, picture, room_of(world)}, why)) << why;
    }
  SetUpTestSuite();
}

TEST(PlantPixels, YuyvIsLimitedRangeBt601AndFlipsRows) {
  // Two rows of two pixels, bottom row first: below white and black, above red twice.
  const std::uint8_t rgbx[] = {255, 255, 255, 0, 0, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0};
  std::uint8_t out[8];
  convert_image(rgbx, 2, 2, msg::PixelFormat::yuyv, out);
  const std::uint8_t red_then_grey[] = {82, 90, 82, 240, 235, 128, 16, 128};
  for (int i = 0; i < 8; ++i) EXPECT_EQ(out[i], red_then_grey[i]) << i;
  std::uint8_t rgb[12];
  convert_image(rgbx, 2, 2, msg::PixelFormat::rgb8, rgb);
  EXPECT_EQ(rgb[0], 255);
  EXPECT_EQ(rgb[1], 0);
  EXPECT_EQ(rgb[6], 255);
  EXPECT_EQ(rgb[9], 0);
}

TEST(PlantPixels, SurfacesWithoutTheirTexturesHaveNoPattern) {
  std::vector<std::uint8_t> rgbx(16 * 16 * 4);
  for (std::size_t i = 0; i < rgbx.size(); ++i) rgbx[i] = static_cast<std::uint8_t>(i % 4 == 3 ? i : 70 + i % 4);
  EXPECT_FALSE(has_pattern(rgbx.data(), 16, 16)) << "the fourth byte is no colour";
  rgbx[rgbx.size() - 3] ^= 1;
  EXPECT_TRUE(has_pattern(rgbx.data(), 16, 16));
}

TEST(PlantPixels, NoiseHasItsSigmaStaysInRangeAndRepeats) {
  const PixelNoise noise(2.0, 5);
  std::vector<std::uint8_t> a(640 * 480 * 2, 128), b = a, bright(640, 255);
  noise.add(a.data(), 1280, 480, 3);
  noise.add(b.data(), 1280, 480, 3);
  EXPECT_EQ(a, b);
  double sum2 = 0;
  for (const std::uint8_t v : a) sum2 += (v - 128.0) * (v - 128.0);
  EXPECT_NEAR(std::sqrt(sum2 / static_cast<double>(a.size())), 2.0, 0.1);
  noise.add(b.data(), 1280, 480, 4);
  EXPECT_NE(a, b);
  noise.add(bright.data(), 640, 1, 1);
  for (const std::uint8_t v : bright) EXPECT_GT(v, 240);
}

/// The view of the first of two vehicles, 2 m up, with the other somewhere.
std::vector<std::uint8_t> view_of_two(Renderer& renderer, const msg::Vec3& other) {
  Scene scene;
  scene.vehicles = 2;
  scene.vehicle[0] = {{0, 0, -50}, {1, 0, 0, 0}};
  scene.vehicle[1] = {other, {1, 0, 0, 0}};
  renderer.place(scene);
  std::vector<std::uint8_t> image(kWidth * kHeight);
  renderer.camera_view({{0.5, 0, 2}, kCameraQBaseOptical}, msg::PixelFormat::mono8, image.data());
  return image;
}

TEST(RendererOfTwo, ACameraSeesTheOtherVehicleWhereItIs) {
  std::string why;
  auto renderer = Renderer::create({kWidth, kHeight, false, room_of("quad"), 2}, why);
  ASSERT_TRUE(renderer) << why;
  const auto beside = view_of_two(**renderer, {0.5, -0.6, 0.12});
  const auto away = view_of_two(**renderer, {3, 3, 0.12});
  double u = 0, v = 0, n = 0;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      if (beside[y * kWidth + x] != away[y * kWidth + x]) u += x, v += y, ++n;
  ASSERT_GT(n, 300);
  EXPECT_NEAR(u / n, kWidth / 2.0 + kFocal * 0.6 / 1.88, 12) << "to the right, where -y is";
  EXPECT_NEAR(v / n, kHeight / 2.0, 8);
}

}  // namespace
}  // namespace sinew::plant::renderer_test
