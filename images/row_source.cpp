#include "images/row_source.hpp"

namespace sinew::images {

bool RowSource::start(const PixelView& view, const Area& area, Order order) {
  view_ = view, area_ = area, order_ = order;
  y_ = 0;
  if (!area.scaled()) return true;
  return converted_.at_least(std::size_t{area.width} * channels()) != nullptr &&
         filter_.start({area.width, area.height}, {area.out_width, area.out_height}, channels());
}

const std::uint8_t* RowSource::unscaled(std::uint32_t y, std::uint8_t* to) const {
  const std::uint8_t* row = view_.bytes.data() + std::size_t{area_.y + y} * view_.stride;
  if (view_.format == msg::PixelFormat::yuyv) {
    yuyv_to_colour(row + std::size_t{area_.x / 2} * 4, area_.x % 2 == 1, area_.width, order_ == Order::bgr, to);
    return to;
  }
  row += std::size_t{area_.x} * msg::bytes_per_pixel(view_.format);
  if (order_of(view_.format) == order_) return row;
  if (view_.format == msg::PixelFormat::mono8)
    grey_to_colour(row, area_.width, to);
  else
    swap_red_and_blue(row, area_.width, to);
  return to;
}

const std::uint8_t* RowSource::next(std::uint8_t* to) {
  if (!area_.scaled()) return unscaled(y_++, to);
  filter_.next([this](std::uint32_t y) { return unscaled(y, converted_.get()); }, to);
  return to;
}

}  // namespace sinew::images
