// 100 cameras with secret lenses, from pictures to intervals; the tables of docs/calibrate.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "board_picture.hpp"

namespace sinew::identify::camera_study {
namespace {

constexpr vision::BoardSize kBoard{9, 6};
constexpr double kSquare = 0.025, kTilt_rad = 0.6;
constexpr std::size_t kCameras = 100, kViews = 20;

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return x.empty() ? math::kNan : x[x.size() / 2];
}

void study(std::uint32_t width, std::uint64_t first) {
  const std::uint32_t height = width * 3 / 4;
  std::array<std::size_t, kCameraNumbers> held{};
  std::array<std::vector<double>, kCameraNumbers> half, off;
  std::vector<double> rms, held_out;
  std::size_t missed = 0;
  for (std::uint64_t seed = first; seed < first + kCameras; ++seed) {
    math::Random random(seed, 3);
    const LensCamera c = test::secret_camera(random, width, height);
    test::BoardPictures pictures(c, kBoard, kSquare, {.width = width, .height = height});
    vision::BoardFinder finder(kBoard);
    std::vector<PlaneView> views;
    for (std::size_t i = 0; i < kViews; ++i) {
      const auto plane = test::held(pictures, c, kBoard, kSquare, width, height, kTilt_rad, random);
      if (!finder.find(pictures.draw(plane, random))) {
        ++missed;
        continue;
      }
      PlaneView view;
      for (std::size_t k = 0; k < finder.corners().size(); ++k)
        view.push_back({static_cast<double>(k % 9) * kSquare, static_cast<double>(k / 9) * kSquare,
                        finder.corners()[k].u_px, finder.corners()[k].v_px});
      views.push_back(std::move(view));
    }
    const CameraFit fit =
        fit_camera(views, {.width_px = static_cast<double>(width), .height_px = static_cast<double>(height)});
    ASSERT_EQ(fit.problem, "") << seed;
    const std::array<double, kCameraNumbers> truth{c.fx_px,   c.fy_px,   c.cx_px,   c.cy_px,
                                                   c.lens.k1, c.lens.k2, c.lens.p1, c.lens.p2};
    for (std::size_t i = 0; i < kCameraNumbers; ++i) {
      const double error = math::fabs(fit.estimates[i].value - truth[i]);
      held[i] += error <= fit.estimates[i].half_width ? 1 : 0;
      half[i].push_back(fit.estimates[i].half_width), off[i].push_back(error);
    }
    rms.push_back(fit.rms_px), held_out.push_back(fit.held_out_rms_px);
  }
  std::printf("%u x %u, cameras %llu to %llu: %zu of %zu pictures missed; off by %.3f px, held out by %.3f (medians)\n",
              width, height, static_cast<unsigned long long>(first),
              static_cast<unsigned long long>(first + kCameras - 1), missed, kCameras * kViews, median(rms),
              median(held_out));
  std::printf("| number | held | median half-width | median error |\n|---|---|---|---|\n");
  for (std::size_t i = 0; i < kCameraNumbers; ++i) {
    std::printf("| %s | %zu | %.2g | %.2g |\n", camera_numbers()[i].name.data(), held[i], median(half[i]),
                median(off[i]));
    EXPECT_GE(held[i], 89u) << camera_numbers()[i].name;
    EXPECT_LE(held[i], 99u) << camera_numbers()[i].name;
  }
  EXPECT_LT(median(half[0]), 0.005 * width);
  EXPECT_LE(missed, kCameras * kViews / 50);
}

TEST(CameraStudy, Of100SecretCamerasOf640x480TheStatedIntervalsHold89To99Times) { study(640, 1000); }
TEST(CameraStudy, Of100SecretCamerasOf320x240TheStatedIntervalsHold89To99Times) { study(320, 2000); }

}  // namespace
}  // namespace sinew::identify::camera_study
