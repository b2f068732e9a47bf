// Pictures of triangles: what they cover, how far it is, and the same bytes everywhere.
#include "sim_hil/raster/raster.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "math/hash.hpp"
#include "math/random.hpp"

namespace sinew::raster {
namespace {

using kinematics::Pose;
using math::Quat;
using math::Vec3;

constexpr std::uint32_t kWidth = 160, kHeight = 120;
const Camera kAhead{{}, 140, 140, 80, 60, 0.02};  // at the origin, in its own axes

/// A camera at `eye` that looks at `target`, upright.
Camera looking(const Vec3& eye, const Vec3& target) {
  const Vec3 z = math::normalized(target - eye), x = math::normalized(cross(z, Vec3{0, 0, 1})), y = cross(z, x);
  Camera c = kAhead;
  c.pose = {eye, Quat::from_matrix({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z})};
  return c;
}

/// Direction of a pixel's ray in the world, with 1 along the camera's z.
Vec3 ray(const Camera& c, std::uint32_t x, std::uint32_t y) {
  return c.pose.q.rotate({(x + 0.5 - c.cx_px) / c.fx_px, (y + 0.5 - c.cy_px) / c.fy_px, 1});
}

Mesh one(const Vec3& a, const Vec3& b, const Vec3& c) { return polygon({a, b, c}); }

TEST(Raster, TrianglesThatShareEdgesCoverEachPixelOnce) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    math::Random random(seed);
    constexpr int kCells = 9;
    Vec3 grid[kCells + 1][kCells + 1];
    for (int i = 0; i <= kCells; ++i)
      for (int j = 0; j <= kCells; ++j)
        grid[i][j] = {(i - 4.5 + random.uniform(-0.3, 0.3)) * 0.3, (j - 4.5 + random.uniform(-0.3, 0.3)) * 0.3,
                      random.uniform(1.4, 1.6)};
    std::vector<int> count(kWidth * kHeight);
    Raster picture(kWidth, kHeight);
    picture.look(kAhead);
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j)
        for (const bool half : {false, true}) {
          const Vec3 &a = grid[i][j], &b = half ? grid[i + 1][j + 1] : grid[i][j + 1],
                     &c = half ? grid[i + 1][j] : grid[i + 1][j + 1];
          picture.clear({});
          picture.draw(one(a, b, c), {}, {9, 9, 9}, 1);
          for (std::size_t k = 0; k < count.size(); ++k) count[k] += picture.pixels()[k] >> 24;
        }
    EXPECT_EQ(std::count(count.begin(), count.end(), 1), static_cast<std::ptrdiff_t>(count.size())) << seed;
  }
}

TEST(Raster, DepthIsThatOfThePlaneThatAPixelShows) {
  const Camera camera = looking({0, 0, 1}, {1, 0.2, 0});
  Raster picture(kWidth, kHeight);
  picture.look(camera);
  picture.clear({});
  picture.draw(polygon({{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}}), {}, {0, 100, 0},
               7);  // also behind the camera
  int ground = 0;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const Vec3 r = ray(camera, x, y);
      const double far = r.z < 0 ? -1 / r.z : 1e9;
      const Vec3 point = Vec3{0, 0, 1} + r * far;
      if (far > 1e8 || math::fabs(point.x) > 45 || math::fabs(point.y) > 45) continue;
      ++ground;
      ASSERT_EQ(picture.shown(x, y), 7) << x << ' ' << y;
      ASSERT_NEAR(picture.depth_m(x, y) / far, 1, 2e-3) << x << ' ' << y;
    }
  EXPECT_GT(ground, 10000);
}

TEST(Raster, WhatIsNearerHidesWhatIsFartherInAnyOrder) {
  math::Random random(3);
  struct Thing {
    Mesh mesh;
    Pose pose;
    std::uint8_t shows;
  };
  std::vector<Thing> things;
  for (std::uint8_t i = 1; i <= 30; ++i) {
    const Pose pose{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 4)},
                    Quat::exp({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)})};
    things.push_back({i % 3 == 0 ? box({0.3, 0.2, 0.4}) : i % 3 == 1 ? sphere(0.2) : capsule(0.1, 0.3), pose, i});
  }
  const auto drawn = [&] {
    Raster picture(kWidth, kHeight);
    picture.look(kAhead);
    picture.clear({1, 2, 3});
    for (const Thing& t : things) picture.draw(t.mesh, t.pose, {200, 100, t.shows}, t.shows);
    return std::vector<std::uint32_t>(picture.pixels().begin(), picture.pixels().end());
  };
  const auto forwards = drawn();
  std::reverse(things.begin(), things.end());
  EXPECT_EQ(drawn(), forwards);
  EXPECT_GT(std::count_if(forwards.begin(), forwards.end(), [](std::uint32_t p) { return p >> 24 != 0; }), 3000);
}

TEST(Raster, ASphereIsADiscOfTheRightSize) {
  Raster picture(kWidth, kHeight);
  picture.look(kAhead);
  picture.clear({});
  picture.draw(sphere(0.5, 60, 30), {{0, 0, 3}, {}}, {250, 120, 20}, 5);
  double pixels = 0;
  for (const std::uint32_t p : picture.pixels()) pixels += p >> 24 == 5 ? 1 : 0;
  const double radius_px = 140 * 0.5 / math::sqrt(3 * 3 - 0.5 * 0.5);
  EXPECT_NEAR(pixels / (math::kPi * radius_px * radius_px), 1, 0.02);
  EXPECT_NEAR(picture.depth_m(80, 60), 2.5, 0.01);
  EXPECT_EQ(picture.depth_m(0, 0), 0);
}

TEST(Raster, AShapeIsClosedFromAllSides) {
  math::Random random(4);
  const Mesh shapes[] = {box({1, 1, 1}), sphere(0.6), capsule(0.3, 0.6), cylinder(0.5, 1)};
  for (const Mesh& mesh : shapes)
    for (int view = 0; view < 20; ++view) {
      // Its volume by its triangles: right only when each looks outwards and none is missing.
      double volume = 0;
      for (const auto& t : mesh.triangles)
        volume += dot(mesh.points[t.corner[0]], cross(mesh.points[t.corner[1]], mesh.points[t.corner[2]])) / 6;
      EXPECT_GT(volume, 0.1);
      Raster picture(kWidth, kHeight);
      picture.look(kAhead);
      picture.clear({});
      picture.draw(mesh, {{0, 0, 3}, Quat::exp({random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)})},
                   {9, 9, 9}, 1);
      // In each row one run of pixels: shapes are convex.
      for (std::uint32_t y = 0; y < kHeight; ++y) {
        int changes = 0;
        for (std::uint32_t x = 1; x < kWidth; ++x) changes += picture.shown(x, y) != picture.shown(x - 1, y) ? 1 : 0;
        ASSERT_TRUE(changes == 0 || changes == 2) << y;
      }
      EXPECT_EQ(picture.shown(80, 60), 1);
    }
}

TEST(Raster, LinesOnAFloorAreSeenAtAnyDistance) {
  const Camera camera = looking({0, 0, 0.5}, {3, 0, 0});
  Raster picture(kWidth, kHeight);
  picture.look(camera);
  picture.clear({});
  picture.draw(polygon({{-10, -10, 0}, {20, -10, 0}, {20, 10, 0}, {-10, 10, 0}}), {}, {0, 100, 0}, 1);
  picture.draw(polygon({{0, -0.5, 0}, {20, -0.5, 0}, {20, 0.5, 0}, {0, 0.5, 0}}), {}, {255, 255, 255}, 2, true);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const Vec3 r = ray(camera, x, y);
      const Vec3 at = Vec3{0, 0, 0.5} + r * (-0.5 / r.z);
      if (r.z >= 0 || at.x > 18 || math::fabs(math::fabs(at.y) - 0.5) < 0.02 * at.x) continue;
      ASSERT_EQ(picture.shown(x, y), math::fabs(at.y) < 0.5 ? 2 : 1) << at.x << ' ' << at.y;
    }
  picture.draw(box({0.2, 2, 0.4}), {{2, 0, 0.2}, {}}, {50, 50, 50}, 3);
  picture.draw(polygon({{0, -0.5, 0}, {20, -0.5, 0}, {20, 0.5, 0}, {0, 0.5, 0}}), {}, {255, 255, 255}, 2, true);
  EXPECT_EQ(picture.shown(80, 60), 3) << "a line behind a box is hidden";
}

TEST(Raster, IsNotLedAstrayByWhatIsFarAsideOrBehindOrNowhere) {
  Raster picture(kWidth, kHeight);
  picture.look(kAhead);
  picture.clear({1, 2, 3});
  const auto empty = std::vector<std::uint32_t>(picture.pixels().begin(), picture.pixels().end());
  for (const Vec3& at : {Vec3{0, 0, -3}, Vec3{100, 0, 1}, Vec3{0, -100, 1}, Vec3{0, 0, -0.6}})
    picture.draw(sphere(0.5), {at, {}}, {9, 9, 9}, 1);
  EXPECT_TRUE(std::equal(empty.begin(), empty.end(), picture.pixels().begin()));
  picture.draw(box({1e6, 1e6, 1e6}), {{0, 0, 1}, {}}, {9, 9, 9}, 1);  // around the camera: its back is not drawn
  EXPECT_TRUE(std::equal(empty.begin(), empty.end(), picture.pixels().begin()));
  picture.draw(polygon({{-1e7, 1, -1e7}, {1e7, 1, -1e7}, {1e7, 1, 1e7}, {-1e7, 1, 1e7}}).moved({{}, {}}), {}, {9, 9, 9},
               1);
  picture.draw(sphere(0.01), {{0, 0, 0.021}, {}}, {9, 9, 9}, 1);
  EXPECT_EQ(picture.shown(80, 60), 1) << "a sphere that the near plane cuts";
}

TEST(Raster, TheSameBytesOnEveryMachine) {
  math::Random random(1);
  Raster picture(kWidth, kHeight);
  picture.look(looking({-3, 0.5, 1.2}, {0, 0, 0.2}));
  picture.clear({135, 170, 210});
  picture.draw(polygon({{-9, -6, 0}, {9, -6, 0}, {9, 6, 0}, {-9, 6, 0}}), {}, {40, 120, 50}, 1);
  picture.draw(ring(0.7, 0.75), {}, {240, 240, 240}, 2, true);
  for (std::uint8_t i = 3; i < 40; ++i) {
    const Pose pose{{random.uniform(-2, 3), random.uniform(-2, 2), random.uniform(0, 1)},
                    Quat::exp({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)})};
    picture.draw(i % 2 ? capsule(0.08, 0.2) : box({0.1, 0.2, 0.3}), pose, {200, static_cast<std::uint8_t>(6 * i), 30},
                 i);
  }
  std::uint64_t hash = math::fnv1a64("");
  for (const std::uint32_t p : picture.pixels())
    for (int shift = 0; shift < 32; shift += 8) {
      const char byte = static_cast<char>(p >> shift & 255);
      hash = math::fnv1a64({&byte, 1}, hash);
    }
  EXPECT_EQ(hash, 17823295579810842043u) << "seen with gcc and clang, on amd64, arm64 and mipsel";
}

}  // namespace
}  // namespace sinew::raster
