// What soccer vision finds in a picture: here a painted one, a white line across a green carpet.
// docs/soccer-vision.md.
#include <cstdio>

#include "msg/image_buffer.hpp"
#include "soccer/sight/field_sight.hpp"

namespace {

using namespace sinew;

constexpr std::uint32_t kWidth = 320, kHeight = 240;
constexpr double kCameraHigh_m = 0.45, kLookDown_rad = 0.5, kLineAhead_m = 0.8, kLineWide_m = 0.05;

void put(std::uint8_t* pair, bool white) {
  const std::uint8_t yuv[2][3] = {{92, 108, 95}, {240, 128, 128}};
  pair[0] = pair[2] = yuv[white][0], pair[1] = yuv[white][1], pair[3] = yuv[white][2];
}

}  // namespace

int main() {
  // A camera over the place where the robot stands, that looks ahead and down.
  msg::CameraPose pose;
  pose.p_world_m = {0, 0, kCameraHigh_m};
  const math::Quat optical{0.5, -0.5, 0.5, -0.5};  // x right, y down, z ahead
  pose.q_world_optical = (math::Quat::from_axis_angle({0, 1, 0}, kLookDown_rad) * optical).to<msg::Quat>();
  const double focal_px = 0.875 * kHeight;
  const vision::Pinhole camera{focal_px, focal_px, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)};
  const soccer::GroundView view(camera, pose, {}, {});

  msg::ImageBuffer image(msg::PixelFormat::yuyv, kWidth, kHeight);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; x += 2) {
      const auto at = view.ground(x, y);
      put(image->row(y) + 2 * x, at && math::fabs(at->x_m - kLineAhead_m) < kLineWide_m / 2);
    }

  soccer::FieldSight sight;
  msg::SoccerSight seen;
  if (!sight.look(vision::view(*image), view, seen)) return 1;
  for (std::uint32_t i = 0; i < seen.lines; ++i) {
    const msg::GroundPoint &a = seen.line[i].from, &b = seen.line[i].to;
    std::printf("a line from %.2f, %.2f to %.2f, %.2f m; along x known to %.0f mm\n", a.x_m, a.y_m, b.x_m, b.y_m,
                1e3 * static_cast<double>(math::sqrt(a.xx_m2)));
  }
  const bool right = seen.lines == 1 && math::fabs(static_cast<double>(seen.line[0].from.x_m) - kLineAhead_m) < 0.02;
  return right && seen.balls == 0 ? 0 : 1;
}
