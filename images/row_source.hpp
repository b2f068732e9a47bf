#pragma once
#include "images/area.hpp"
#include "images/box_filter.hpp"

namespace sinew::images {

/// The rows of a part of a picture as a file wants them: cut, in its order of channels, scaled.
class RowSource {
 public:
  enum class Order : std::uint8_t { grey, rgb, bgr };  // grey only of mono8
  /// False: no memory.
  [[nodiscard]] bool start(const PixelView& view, const Area& area, Order order);
  std::uint32_t channels() const { return order_ == Order::grey ? 1 : 3; }
  std::size_t row_bytes() const { return std::size_t{area_.out_width} * channels(); }
  /// The next row from above: the picture's own bytes where they are as wanted; else it fills `to` and returns it.
  const std::uint8_t* next(std::uint8_t* to);

 private:
  const std::uint8_t* unscaled(std::uint32_t y, std::uint8_t* to) const;

  PixelView view_;
  Area area_;
  Order order_ = Order::grey;
  std::uint32_t y_ = 0;
  BoxFilter filter_;
  Buffer<std::uint8_t> converted_;  // one row before scaling
};

/// The order that needs the least work: grey of mono8, bgr of bgr8, else rgb.
inline RowSource::Order order_of(msg::PixelFormat format) {
  if (format == msg::PixelFormat::mono8) return RowSource::Order::grey;
  return format == msg::PixelFormat::bgr8 ? RowSource::Order::bgr : RowSource::Order::rgb;
}

}  // namespace sinew::images
