#pragma once
// A field painted pixel by pixel for tests: carpet, the lines of soccer::Field, the circle, a ball, whatever stands on
// it.
#include <functional>
#include <optional>

#include "msg/image_buffer.hpp"
#include "soccer/field.hpp"
#include "soccer/sight/ground_view.hpp"
#include "vision/colour_table.hpp"

namespace sinew::soccer::test {

struct Painting {
  RobotAt robot{-1, 0, 0};      // in the frame "field"
  double camera_high_m = 0.45;  // above the robot's place
  double look_down_rad = 0.35, look_left_rad = 0;
  std::optional<FieldPoint> ball{};
  struct Pole {
    FieldPoint at;
    double radius_m, high_m;
    vision::Rgb colour;
  };
  std::vector<Pole> poles{};
  double light = 1;
  std::uint32_t width = 320, height = 240;

  msg::CameraPose pose(msg::Time stamp = {}) const {
    msg::CameraPose p;
    p.stamp = stamp;
    p.p_world_m = {robot.x_m, robot.y_m, camera_high_m};
    const math::Quat optical{0.5, -0.5, 0.5, -0.5};
    const math::Quat turn = math::Quat::from_axis_angle({0, 0, 1}, robot.heading_rad + look_left_rad) *
                            math::Quat::from_axis_angle({0, 1, 0}, look_down_rad);
    p.q_world_optical = (turn * optical).to<msg::Quat>();
    return p;
  }
  vision::Pinhole camera() const {
    const double f = 0.875 * height;
    return {f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
  }
  GroundView view(const ViewErrors& errors = {}) const { return {camera(), pose(), robot, errors}; }

  msg::ImageBuffer paint(msg::Time stamp = {}) const {
    msg::ImageBuffer image(msg::PixelFormat::yuyv, width, height);
    image->stamp = stamp;
    const Field field;
    const msg::CameraPose p = pose();
    const math::Vec3 eye(p.p_world_m);
    const math::Quat q(p.q_world_optical);
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; x += 2) {
        vision::Yuv two[2];
        for (std::uint32_t k = 0; k < 2; ++k) {
          std::array<double, 3> sum{};
          for (int s = 0; s < 4; ++s) {
            const double u = x + k + 0.5 * (s % 2) - 0.25, v = y + 0.5 * (s / 2) - 0.25;
            const vision::Rgb c = shade(field, eye, q.rotate(math::Vec3(camera().direction(u, v))));
            sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
          }
          const auto byte = [&](double v) { return std::clamp(static_cast<int>(v / 4 * light + 0.5), 0, 255); };
          two[k] = vision::to_yuv({byte(sum[0]), byte(sum[1]), byte(sum[2])});
        }
        std::uint8_t* to = image->row(y) + 2 * x;
        to[0] = static_cast<std::uint8_t>(two[0].y), to[1] = static_cast<std::uint8_t>((two[0].u + two[1].u) / 2);
        to[2] = static_cast<std::uint8_t>(two[1].y), to[3] = static_cast<std::uint8_t>((two[0].v + two[1].v) / 2);
      }
    return image;
  }

 private:
  vision::Rgb shade(const Field& field, const math::Vec3& eye, const math::Vec3& way) const {
    constexpr double kRadius_m = 0.07;
    if (ball) {
      const math::Vec3 to = math::Vec3{ball->x_m, ball->y_m, kRadius_m} - eye;
      const double along = dot(to, way), off2 = squared_norm(to) - along * along;
      if (along > 0 && off2 < kRadius_m * kRadius_m) {
        const math::Vec3 n = way * (along - math::sqrt(kRadius_m * kRadius_m - off2)) - to;
        const double bright = 0.55 + 0.45 * std::max(0.0, n.z / kRadius_m);
        const bool black = math::sin(40 * n.x) * math::sin(40 * n.y) + math::sin(40 * n.z) * 0.5 > 0.45;
        const int v = static_cast<int>((black ? 30 : 240) * bright);
        return {v, v, v};
      }
    }
    const double ground = way.z < 0 ? -eye.z / way.z : math::kInf;
    for (const Pole& p : poles) {
      const double dx = p.at.x_m - eye.x, dy = p.at.y_m - eye.y, flat = math::hypot(way.x, way.y);
      const double along = (dx * way.x + dy * way.y) / flat, off = (dx * way.y - dy * way.x) / flat;
      const double t = along / flat, z = eye.z + t * way.z;
      if (along > 0 && math::fabs(off) < p.radius_m && z > 0 && z < p.high_m) return p.colour;
    }
    const double x = eye.x + ground * way.x, y = eye.y + ground * way.y;
    const FieldSize& f = field.size();
    if (!(math::fabs(x) < f.length_m / 2 + f.border_m && math::fabs(y) < f.width_m / 2 + f.border_m))
      return {168, 184, 200};
    bool line = math::fabs(math::hypot(x, y) - f.circle_radius_m) < 0.025;
    for (const FieldLine& l : field.lines()) {
      const double x0 = std::min(l.from.x_m, l.to.x_m) - 0.025, x1 = std::max(l.from.x_m, l.to.x_m) + 0.025;
      const double y0 = std::min(l.from.y_m, l.to.y_m) - 0.025, y1 = std::max(l.from.y_m, l.to.y_m) + 0.025;
      line = line || (x > x0 && x < x1 && y > y0 && y < y1);
    }
    for (const FieldPoint& m : field.penalty_marks()) {
      const double dx = math::fabs(x - m.x_m), dy = math::fabs(y - m.y_m);
      line = line || (std::min(dx, dy) < 0.025 && std::max(dx, dy) < 0.1);
    }
    return line ? vision::Rgb{240, 240, 240} : vision::Rgb{46, 122, 56};
  }
};

}  // namespace sinew::soccer::test
