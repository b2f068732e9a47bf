#include "apps/sight/draw.hpp"

#include <algorithm>
#include <cstdio>

#include "images/encode.hpp"
#include "vision/colour_table.hpp"

namespace sinew::sight {
namespace {

using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb kBorder{255, 255, 0}, kLine{255, 40, 40}, kMark{0, 255, 255}, kPost{255, 0, 255}, kBall{255, 150, 0},
    kCandidate{120, 120, 255}, kUnknown{255, 255, 255}, kBlue{60, 120, 255}, kRed{255, 60, 60};

struct Pen {
  Drawing& to;
  void dot(double u, double v, const Rgb& c) const {
    const int x = static_cast<int>(math::floor(u + 0.5)), y = static_cast<int>(math::floor(v + 0.5));
    if (x < 0 || y < 0 || x >= static_cast<int>(to.width) || y >= static_cast<int>(to.height)) return;
    std::copy(c.begin(), c.end(), &to.rgb[3 * (static_cast<std::size_t>(y) * to.width + static_cast<std::size_t>(x))]);
  }
  void line(double u0, double v0, double u1, double v1, const Rgb& c) const {
    const double n = std::max({1.0, math::fabs(u1 - u0), math::fabs(v1 - v0)});
    for (double s = 0; s <= n; ++s) dot(u0 + s / n * (u1 - u0), v0 + s / n * (v1 - v0), c);
  }
  void circle(double u, double v, double r, const Rgb& c) const {
    const int n = std::max(16, static_cast<int>(7 * r));
    for (int k = 0; k < n; ++k) {
      const math::SinCos t = math::sincos(2 * math::kPi * k / n);
      dot(u + r * t.cos, v + r * t.sin, c);
    }
  }
  void box(double u0, double v0, double u1, double v1, const Rgb& c) const {
    line(u0, v0, u1, v0, c), line(u1, v0, u1, v1, c), line(u1, v1, u0, v1, c), line(u0, v1, u0, v0, c);
  }
};

/// Strokes of L, T, X, +, O in a box of 2 x 2 round the middle.
void sign(const Pen& pen, double u, double v, msg::FieldMark kind) {
  const double s = 4;
  switch (kind) {
    case msg::FieldMark::corner_l:
      pen.line(u - s, v - s, u - s, v + s, kMark), pen.line(u - s, v + s, u + s, v + s, kMark);
      break;
    case msg::FieldMark::corner_t:
      pen.line(u - s, v - s, u + s, v - s, kMark), pen.line(u, v - s, u, v + s, kMark);
      break;
    case msg::FieldMark::corner_x:
      pen.line(u - s, v - s, u + s, v + s, kMark), pen.line(u - s, v + s, u + s, v - s, kMark);
      break;
    case msg::FieldMark::penalty_mark:
      pen.line(u - s, v, u + s, v, kMark), pen.line(u, v - s, u, v + s, kMark);
      break;
    case msg::FieldMark::circle:
      pen.circle(u, v, s, kMark);
      break;
  }
}

}  // namespace

Drawing draw(const vision::ImageView& image, const soccer::GroundView& view, const soccer::FieldSight& sight,
             const msg::SoccerSight& seen) {
  Drawing out{image.width, image.height, {}};
  out.rgb.resize(std::size_t{image.width} * image.height * 3);
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::uint8_t *p = image.row(y) + 2 * x, *pair = image.row(y) + (x & ~1U) * 2;
      const vision::Rgb c = vision::to_rgb({p[0], pair[1], pair[3]});
      std::uint8_t* const to = &out.rgb[3 * (std::size_t{y} * image.width + x)];
      to[0] = static_cast<std::uint8_t>(c.r), to[1] = static_cast<std::uint8_t>(c.g),
      to[2] = static_cast<std::uint8_t>(c.b);
    }
  const Pen pen{out};
  const auto pixel = [&](const msg::GroundPoint& p) { return view.pixel(soccer::GroundXy{p.x_m, p.y_m}); };
  if (sight.border().found())
    for (std::uint32_t x = 0; x < image.width; ++x) pen.dot(x, sight.border().row_px(x), kBorder);
  for (std::uint32_t i = 0; i < seen.lines; ++i) {
    const soccer::PixelAt a = pixel(seen.line[i].from), b = pixel(seen.line[i].to);
    pen.line(a.u_px, a.v_px, b.u_px, b.v_px, kLine);
  }
  if (sight.lines().circle()) {
    const soccer::CirclePiece& c = *sight.lines().circle();
    for (int k = 0; k < 360; ++k) {
      const math::SinCos t = math::sincos(k * math::kPi / 180);
      const soccer::PixelAt at =
          view.pixel(soccer::GroundXy{c.centre.x_m + c.radius_m * t.cos, c.centre.y_m + c.radius_m * t.sin});
      if (at.depth_m > 0) pen.dot(at.u_px, at.v_px, kLine);
    }
  }
  for (std::uint32_t i = 0; i < seen.posts; ++i) {
    const soccer::PixelAt at = pixel(seen.post[i]);
    pen.line(at.u_px, at.v_px, at.u_px, at.v_px - 25.0 * image.height / 240, kPost);
    pen.line(at.u_px - 4, at.v_px, at.u_px + 4, at.v_px, kPost);
  }
  for (const soccer::Uprights::Thing& t : sight.uprights().things()) {
    if (t.is_post) continue;
    const soccer::PixelAt at = view.pixel(t.feet);
    const double high = 0.5 * view.camera().fx_px / std::max(0.1, at.depth_m);
    const Rgb& c = std::max(t.blue, t.red) < 0.04 ? kUnknown : t.blue > t.red ? kBlue : kRed;
    pen.box(t.u0_px, t.foot_px - high, t.u1_px, t.foot_px, c);
  }
  for (std::uint32_t i = 0; i < seen.marks; ++i) {
    const soccer::PixelAt at = pixel(seen.mark[i].at);
    sign(pen, at.u_px, at.v_px, seen.mark[i].kind);
  }
  for (const soccer::BallCandidate& c : sight.candidates().all())
    if (sight.border().found()) pen.circle(c.u_px, c.v_px, c.radius_px, kCandidate);
  for (std::uint32_t i = 0; i < seen.balls; ++i)
    for (const double more : {0.0, 1.0})
      pen.circle(seen.ball[i].u_px, seen.ball[i].v_px, seen.ball[i].radius_px + more, kBall);
  return out;
}

Drawing side_by_side(const std::vector<Drawing>& all, std::size_t columns) {
  if (all.empty()) return {};
  const std::uint32_t w = all[0].width, h = all[0].height, gap = 4;
  const std::size_t rows = (all.size() + columns - 1) / columns;
  Drawing out{
      static_cast<std::uint32_t>(columns) * (w + gap) - gap, static_cast<std::uint32_t>(rows) * (h + gap) - gap, {}};
  out.rgb.assign(std::size_t{out.width} * out.height * 3, 255);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::uint32_t y = 0; y < h; ++y)
      std::copy_n(&all[i].rgb[std::size_t{y} * w * 3], w * 3,
                  &out.rgb[3 * ((i / columns * (h + gap) + y) * out.width + i % columns * (w + gap))]);
  return out;
}

bool write_png(const std::string& path, const Drawing& picture) {
  images::Encoder encoder;
  const auto png =
      encoder.encode({picture.rgb, picture.width, picture.height, picture.width * 3, msg::PixelFormat::rgb8},
                     images::Kind::png, {}, {});
  FILE* const out = png ? std::fopen(path.c_str(), "wb") : nullptr;
  if (!out) return false;
  const bool whole = std::fwrite(png->data(), 1, png->size(), out) == png->size();
  return (std::fclose(out) == 0) && whole;
}

}  // namespace sinew::sight
