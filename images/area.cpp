#include "images/area.hpp"

#include <algorithm>

namespace sinew::images {
namespace {

hal::Error refused(const char* why) { return {hal::Errc::bad_argument, why, 0}; }

std::uint32_t scaled_side(std::uint32_t side, double scale) {
  return std::clamp(static_cast<std::uint32_t>(side * scale + 0.5), 1u, side);
}

}  // namespace

hal::Result<Area> area_of(const PixelView& view, const Cut& cut) {
  const std::uint32_t pixel = msg::bytes_per_pixel(view.format);
  if (pixel == 0 || view.width == 0 || view.height == 0) return refused("picture: it has no pixels");
  if (view.width > kMaxSide || view.height > kMaxSide || view.width * view.height > kMaxPixels)
    return refused("picture: more than 16384 pixels wide or high, or more than 16777216 pixels");
  const std::uint32_t whole = view.format == msg::PixelFormat::yuyv ? (view.width + 1) / 2 * 2 : view.width;
  const std::uint64_t row = std::uint64_t{whole} * pixel;
  if (view.stride < row) return refused("picture: its stride is shorter than a row");
  if (!view.bytes.data() || std::uint64_t{view.stride} * (view.height - 1) + row > view.bytes.size())
    return refused("picture: fewer bytes than its rows need");
  if (cut.x >= view.width || cut.y >= view.height) return refused("region: it begins outside of the picture");
  if (!(cut.scale > 0 && cut.scale <= 1)) return refused("scale: above 0, at most 1");
  Area area{cut.x, cut.y, view.width - cut.x, view.height - cut.y, 0, 0};
  if (cut.width != 0) area.width = std::min(area.width, cut.width);
  if (cut.height != 0) area.height = std::min(area.height, cut.height);
  area.out_width = scaled_side(area.width, cut.scale), area.out_height = scaled_side(area.height, cut.scale);
  return area;
}

}  // namespace sinew::images
