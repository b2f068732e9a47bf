#include "apps/calibrate/lens_picture.hpp"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "dataset/png_image.hpp"

namespace sinew::app {
namespace {

struct Paper {
  std::uint32_t width, height;
  std::vector<std::uint8_t> rgb;

  void dot(double x, double y, double radius, const std::uint8_t (&colour)[3]) {
    for (int v = static_cast<int>(y - radius); v <= static_cast<int>(y + radius) + 1; ++v)
      for (int u = static_cast<int>(x - radius); u <= static_cast<int>(x + radius) + 1; ++u) {
        if (u < 0 || v < 0 || u >= static_cast<int>(width) || v >= static_cast<int>(height)) continue;
        if (std::hypot(u - x, v - y) > radius) continue;
        std::memcpy(&rgb[3 * (static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u))], colour, 3);
      }
  }
  void line(double x0, double y0, double x1, double y1, const std::uint8_t (&colour)[3]) {
    const int steps = static_cast<int>(2 * std::hypot(x1 - x0, y1 - y0)) + 1;
    for (int i = 0; i <= steps; ++i) {
      const double part = static_cast<double>(i) / steps;
      dot(x0 + part * (x1 - x0), y0 + part * (y1 - y0), 0.7, colour);
    }
  }
};

}  // namespace

std::string draw_lens(const std::string& path, const RecordedBoards& boards,
                      const std::vector<identify::PlaneView>& views, const identify::CameraFit& fit, double longer) {
  Paper p{2 * boards.width, 2 * boards.height, {}};
  p.rgb.resize(std::size_t{3} * p.width * p.height);
  for (std::uint32_t y = 0; y < p.height; ++y)
    for (std::uint32_t x = 0; x < p.width; ++x) {
      const std::uint8_t grey = boards.sample[std::size_t{y / 2} * boards.width + x / 2];
      std::memset(&p.rgb[3 * (std::size_t{y} * p.width + x)], 150 + grey * 2 / 5, 3);
    }
  constexpr std::uint8_t kCorner[3] = {20, 90, 200}, kOff[3] = {220, 40, 30}, kAxis[3] = {0, 130, 60};
  for (std::size_t i = 0; i < views.size(); ++i)
    for (const identify::PlanePoint& point : views[i]) {
      const auto at = fit.camera.pixel(fit.plane[i].of({point.x_m, point.y_m, 0}));
      const double x = 2 * point.u_px + 1, y = 2 * point.v_px + 1;
      p.line(x, y, x + 2 * longer * (point.u_px - at.u_px), y + 2 * longer * (point.v_px - at.v_px), kOff);
      p.dot(x, y, 1.5, kCorner);
    }
  const double x = 2 * fit.camera.cx_px + 1, y = 2 * fit.camera.cy_px + 1;
  p.line(x - 12, y, x + 12, y, kAxis), p.line(x, y - 12, x, y + 12, kAxis);
  std::string why;
  const std::string png = dataset::encode_png(msg::PixelFormat::rgb8, p.width, p.height, 3 * p.width, p.rgb, why);
  if (png.empty()) return why;
  std::FILE* const out = std::fopen(path.c_str(), "wb");
  if (!out) return std::strerror(errno);
  const bool all = std::fwrite(png.data(), 1, png.size(), out) == png.size();
  return std::fclose(out) == 0 && all ? std::string() : std::strerror(errno);
}

}  // namespace sinew::app
