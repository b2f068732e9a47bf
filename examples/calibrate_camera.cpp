// A camera calibrated from views of a flat pattern whose points are known; here the views are made up.
//
//   build/release/examples/example_calibrate_camera
#include <cmath>
#include <cstdio>

#include "identify/camera_fit.hpp"
#include "math/random.hpp"

using namespace sinew;

constexpr int kColumns = 9, kRows = 6;
constexpr double kSquare_m = 0.025, kNoise_px = 0.1;

int main() {
  const identify::LensCamera secret{505, 503, 322, 236, {-0.21, 0.06, 0.0004, -0.0002, 0}};
  math::Random random(1);
  std::vector<identify::PlaneView> views;
  while (views.size() < 25) {
    // A board held before the camera, tilted another way each time.
    const kinematics::Pose board{{random.uniform(-0.25, 0.1), random.uniform(-0.2, 0.1), random.uniform(0.3, 0.6)},
                                 math::Quat::exp({random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), 0})};
    identify::PlaneView view;
    for (int i = 0; i < kColumns * kRows; ++i) {
      const double x = i % kColumns * kSquare_m, y = i / kColumns * kSquare_m;
      const auto at = secret.pixel(board.of({x, y, 0}));
      const bool inside = at.u_px > 0 && at.u_px < 639 && at.v_px > 0 && at.v_px < 479;
      if (inside) view.push_back({x, y, at.u_px + random.normal(0, kNoise_px), at.v_px + random.normal(0, kNoise_px)});
    }
    if (view.size() == kColumns * kRows) views.push_back(view);
  }

  const identify::CameraFit fit = identify::fit_camera(views, {.width_px = 640, .height_px = 480});
  if (!fit.problem.empty()) return std::printf("%s\n", fit.problem.c_str()), 1;
  for (std::size_t i = 0; i < identify::kCameraNumbers; ++i)
    std::printf("%s %10.5g +- %.2g %s\n", identify::camera_numbers()[i].name.data(), fit.estimates[i].value,
                fit.estimates[i].half_width, identify::camera_numbers()[i].unit.data());
  std::printf("off by %.3f px RMS, in views that were not fitted by %.3f px\n", fit.rms_px, fit.held_out_rms_px);
  for (const std::string& unknown : fit.unknown) std::printf("not shown: %s\n", unknown.c_str());
  const bool found = std::abs(fit.camera.fx_px - secret.fx_px) < 2 * fit.estimates[0].half_width;
  return found ? 0 : 1;
}
