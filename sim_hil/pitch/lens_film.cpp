#include "sim_hil/pitch/lens_film.hpp"

#include <algorithm>

namespace sinew::plant {
namespace {

constexpr double kWidest = 3;  // half of the fine picture / focal length: 143 degrees across

/// Where a pinhole sees what the lens puts there; far outside where it puts nothing.
math::LensDistortion::Xy straight(double u_px, double v_px, double focal_px, const math::LensDistortion& lens) {
  math::LensDistortion::Xy at{u_px / focal_px, v_px / focal_px};
  if (!lens.straighten(at)) at.x *= 100, at.y *= 100;
  return at;
}

}  // namespace

raster::Raster LensFilm::large_enough(std::uint32_t width, std::uint32_t height, double focal_px,
                                      const math::LensDistortion& lens) {
  double x = 0, y = 0;
  const double half_u = 0.5 * width, half_v = 0.5 * height;
  for (int i = -16; i <= 16; ++i)
    for (const double side : {-1.0, 1.0})
      for (const auto& at : {straight(side * half_u, half_v * i / 16, focal_px, lens),
                             straight(half_u * i / 16, side * half_v, focal_px, lens)})
        x = std::max(x, math::fabs(at.x)), y = std::max(y, math::fabs(at.y));
  const auto pixels = [&](double half) {
    return 2 * (static_cast<std::uint32_t>(kFiner * focal_px * std::min(half, kWidest)) + 1);
  };
  return {pixels(x), pixels(y)};
}

LensFilm::LensFilm(std::uint32_t width, std::uint32_t height, double focal_px, const math::LensDistortion& lens)
    : focal_px_(focal_px), fine_(large_enough(width, height, focal_px, lens)), picture_(std::size_t{width} * height) {
  from_.reserve(picture_.size() * kFiner * kFiner);
  const auto place = [&](double at, std::uint32_t size) {
    const double p = kFiner * focal_px * at + 0.5 * size;
    return static_cast<std::uint32_t>(std::clamp(p, 0.0, size - 1.0));
  };
  for (std::uint32_t v = 0; v < height; ++v)
    for (std::uint32_t u = 0; u < width; ++u)
      for (int k = 0; k < kFiner * kFiner; ++k) {
        const auto at = straight(u + (k % kFiner + 0.5) / kFiner - 0.5 * width,
                                 v + (k / kFiner + 0.5) / kFiner - 0.5 * height, focal_px, lens);
        from_.push_back(place(at.y, fine_.height()) * fine_.width() + place(at.x, fine_.width()));
      }
}

std::span<const std::uint32_t> LensFilm::develop() {
  const std::span<const std::uint32_t> fine = fine_.pixels();
  constexpr std::uint32_t kAll = kFiner * kFiner;
  for (std::size_t i = 0; i < picture_.size(); ++i) {
    const std::uint32_t* from = &from_[i * kAll];
    std::uint32_t r = kAll / 2, g = r, b = r;
    for (std::uint32_t k = 0; k < kAll; ++k) {
      const std::uint32_t p = fine[from[k]];
      r += p & 0xff, g += p >> 8 & 0xff, b += p >> 16 & 0xff;
    }
    picture_[i] = r / kAll | g / kAll << 8 | b / kAll << 16 | (fine[from[kAll / 2]] & 0xff000000u);
  }
  return picture_;
}

}  // namespace sinew::plant
