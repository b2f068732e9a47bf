#include "sim_hil/raster/raster.hpp"

#include <algorithm>

namespace sinew::raster {
namespace {

using math::Vec3;

constexpr std::uint32_t kMostSide = 8192;
constexpr double kParts = 256;            // of a pixel, to which corners are rounded
constexpr double kFarthest_px = 1 << 20;  // corners beyond are pulled in: no product of two leaves 64 bits
constexpr float kOnSurface = 0.998F;      // of the nearness of what it lies on

std::int64_t rounded(double v) { return static_cast<std::int64_t>(v < 0 ? v - 0.5 : v + 0.5); }

std::int64_t divided_down(std::int64_t a, std::int64_t b) {  // b > 0
  const std::int64_t q = a / b;
  return q * b > a ? q - 1 : q;
}

std::uint32_t shaded(Colour c, double light) {
  const auto part = [&](std::uint8_t v) {
    return static_cast<std::uint32_t>(std::clamp(static_cast<double>(v) * light + 0.5, 0.0, 255.0));
  };
  return part(c.r) | part(c.g) << 8 | part(c.b) << 16;
}

/// a * x + b * y + c >= 0 for pixels on the inner side of an edge, in parts of a pixel.
struct Edge {
  std::int64_t a, b, c;
  Edge(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) : a(y0 - y1), b(x1 - x0), c(0) {
    c = -(a * x0 + b * y0);
    // A pixel on the edge itself belongs to the triangle whose left or upper edge it is.
    const bool left_or_top = a > 0 || (a == 0 && b > 0);
    if (!left_or_top) c -= 1;
  }
};

}  // namespace

Raster::Raster(std::uint32_t width, std::uint32_t height)
    : width_(std::clamp<std::uint32_t>(width, 1, kMostSide)),
      height_(std::clamp<std::uint32_t>(height, 1, kMostSide)),
      pixel_(std::size_t{width_} * height_),
      nearness_(pixel_.size()) {}

void Raster::look(const Camera& camera) {
  camera_ = camera;
  camera_world_ = camera.pose.inverse();
}

void Raster::clear(Colour sky) {
  std::fill(pixel_.begin(), pixel_.end(), shaded(sky, 1));
  std::fill(nearness_.begin(), nearness_.end(), 0.0F);
}

Colour Raster::rgb(std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t p = pixel_[std::size_t{y} * width_ + x];
  return {static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(p >> 8), static_cast<std::uint8_t>(p >> 16)};
}

double Raster::depth_m(std::uint32_t x, std::uint32_t y) const {
  const float nearness = nearness_[std::size_t{y} * width_ + x];
  return nearness > 0 ? 1 / static_cast<double>(nearness) : 0;
}

Raster::Corner Raster::projected(const Vec3& p) const {
  const double nearness = 1 / p.z;
  return {std::clamp(camera_.cx_px + camera_.fx_px * p.x * nearness, -kFarthest_px, kFarthest_px),
          std::clamp(camera_.cy_px + camera_.fy_px * p.y * nearness, -kFarthest_px, kFarthest_px), nearness};
}

void Raster::draw(const Mesh& mesh, const kinematics::Pose& pose, Colour colour, std::uint8_t shows, bool on_surface) {
  const kinematics::Pose to_camera = camera_world_ * pose;
  // The whole mesh may be outside: behind, or on the far side of one of the four planes through the picture's borders.
  const Vec3 middle = to_camera.of(mesh.middle);
  if (middle.z + mesh.radius_m < camera_.near_m) return;
  const auto beyond = [&](double along, double focal_px, double border_px) {
    return (along * focal_px - middle.z * border_px) > mesh.radius_m * (focal_px + math::fabs(border_px));
  };
  if (beyond(middle.x, camera_.fx_px, width_ - camera_.cx_px) || beyond(-middle.x, camera_.fx_px, camera_.cx_px) ||
      beyond(middle.y, camera_.fy_px, height_ - camera_.cy_px) || beyond(-middle.y, camera_.fy_px, camera_.cy_px))
    return;

  const math::Mat3 turn = to_camera.q.matrix();
  seen_.resize(mesh.points.size());
  corner_.resize(mesh.points.size());
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    seen_[i] = turn * mesh.points[i] + to_camera.p_m;
    if (seen_[i].z >= camera_.near_m) corner_[i] = projected(seen_[i]);
  }
  const Vec3 light = pose.q.conjugate().rotate(math::normalized(light_.from));
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Vec3 &a = seen_[t.corner[0]], &b = seen_[t.corner[1]], &c = seen_[t.corner[2]];
    if (dot(turn * t.normal, a) >= 0) continue;  // its back
    const std::uint32_t pixel = shaded(colour, light_.ambient + light_.diffuse * std::max(0.0, dot(t.normal, light))) |
                                std::uint32_t{shows} << 24;
    if (a.z >= camera_.near_m && b.z >= camera_.near_m && c.z >= camera_.near_m)
      triangle(corner_[t.corner[0]], corner_[t.corner[2]], corner_[t.corner[1]], pixel, on_surface);
    else
      clipped(a, c, b, pixel, on_surface);
  }
}

/// Cuts off what is nearer than the near plane: a triangle, or two, is left.
void Raster::clipped(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t pixel, bool on_surface) {
  const Vec3 corner[3] = {a, b, c};
  Corner left[4];
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &from = corner[i], &to = corner[(i + 1) % 3];
    const bool from_in = from.z >= camera_.near_m, to_in = to.z >= camera_.near_m;
    if (from_in) left[count++] = projected(from);
    if (from_in == to_in) continue;
    // The same point for both triangles of an edge, whichever way it is gone.
    const Vec3 &in = from_in ? from : to, &out = from_in ? to : from;
    Vec3 cut = in + (out - in) * ((camera_.near_m - in.z) / (out.z - in.z));
    cut.z = camera_.near_m;
    left[count++] = projected(cut);
  }
  for (int i = 2; i < count; ++i) triangle(left[0], left[i - 1], left[i], pixel, on_surface);
}

/// Corners clockwise in the picture.
void Raster::triangle(const Corner& a, const Corner& b, const Corner& c, std::uint32_t pixel, bool on_surface) {
  // Pixel (x, y) has its middle at half coordinates: moved there, so that pixels are multiples of kParts.
  const auto parts = [](double px) { return rounded((px - 0.5) * kParts); };
  constexpr auto kPart = static_cast<std::int64_t>(kParts);
  const std::int64_t ax = parts(a.x_px), ay = parts(a.y_px), bx = parts(b.x_px), by = parts(b.y_px), cx = parts(c.x_px),
                     cy = parts(c.y_px);
  const std::int64_t area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (area <= 0) return;
  const std::int64_t low_y = std::min({ay, by, cy}), high_y = std::max({ay, by, cy});
  const std::int64_t low_x = std::min({ax, bx, cx}), high_x = std::max({ax, bx, cx});
  const std::int64_t first_y = std::max<std::int64_t>(0, -divided_down(-low_y, kPart));
  const std::int64_t last_y = std::min<std::int64_t>(std::int64_t{height_} - 1, divided_down(high_y, kPart));
  const std::int64_t first_x = std::max<std::int64_t>(0, -divided_down(-low_x, kPart));
  const std::int64_t last_x = std::min<std::int64_t>(std::int64_t{width_} - 1, divided_down(high_x, kPart));
  if (first_y > last_y || first_x > last_x) return;
  const Edge edges[3] = {{ax, ay, bx, by}, {bx, by, cx, cy}, {cx, cy, ax, ay}};

  // Nearness is linear in the picture: by the corners as they were rounded, so that it does not step where they moved.
  const auto whole = static_cast<double>(area);
  const double bnx = static_cast<double>(bx - ax), bny = static_cast<double>(by - ay);
  const double cnx = static_cast<double>(cx - ax), cny = static_cast<double>(cy - ay);
  const double nb = b.nearness - a.nearness, nc = c.nearness - a.nearness;
  const double slope_x = (nb * cny - nc * bny) / whole * kParts, slope_y = (nc * bnx - nb * cnx) / whole * kParts;
  const double at_a_x = static_cast<double>(ax) / kParts, at_a_y = static_cast<double>(ay) / kParts;

  for (std::int64_t y = first_y; y <= last_y; ++y) {
    std::int64_t from = first_x, to = last_x;
    for (const Edge& e : edges) {
      const std::int64_t rest = e.b * y * kPart + e.c;  // a * x * kPart + rest >= 0
      if (e.a > 0)
        from = std::max(from, -divided_down(rest, e.a * kPart));
      else if (e.a < 0)
        to = std::min(to, divided_down(rest, -e.a * kPart));
      else if (rest < 0)
        to = -1;
    }
    if (from > to) continue;
    const double start =
        a.nearness + slope_x * (static_cast<double>(from) - at_a_x) + slope_y * (static_cast<double>(y) - at_a_y);
    const auto step = static_cast<float>(slope_x);
    const auto base = static_cast<float>(start);
    const auto count = static_cast<std::int32_t>(to - from + 1);
    const std::size_t at = static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(from);
    float* __restrict const nearness = nearness_.data() + at;
    std::uint32_t* __restrict const out = pixel_.data() + at;
    if (on_surface) {
      for (std::int32_t i = 0; i < count; ++i) {
        const float n = base + step * static_cast<float>(i);
        const bool in_front = n >= nearness[i] * kOnSurface;
        nearness[i] = in_front && n > nearness[i] ? n : nearness[i];
        out[i] = in_front ? pixel : out[i];
      }
    } else {
      for (std::int32_t i = 0; i < count; ++i) {
        const float n = base + step * static_cast<float>(i);
        const bool in_front = n > nearness[i];
        nearness[i] = in_front ? n : nearness[i];
        out[i] = in_front ? pixel : out[i];
      }
    }
  }
}

}  // namespace sinew::raster
