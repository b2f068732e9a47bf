#include "sim_hil/plant/frame_faults.hpp"

#include <algorithm>
#include <cstring>

namespace sinew::plant {

FrameFaults::FrameFaults(FaultLog& log, msg::PixelFormat format, std::uint32_t width, std::uint32_t height)
    : faults_(log, FaultDevice::camera),
      row_bytes_(width * msg::bytes_per_pixel(format)),
      unit_bytes_(format == msg::PixelFormat::yuyv ? 4 : msg::bytes_per_pixel(format)),  // a pair shares its colour
      height_(height) {
  if (any()) drawn_.resize(std::size_t{row_bytes_} * height);
}

hal::Status FrameFaults::offer(sim_hil::FrameMeta meta, const Send& send) {
  const FaultEffect effect = faults_.next(meta.stamp);
  if (effect.stuck && !last_.empty())
    drawn_ = last_;
  else
    last_ = drawn_;
  if (effect.wrong) move_right(*effect.wrong);
  if (effect.garbage)
    for (std::uint8_t& byte : drawn_) byte = static_cast<std::uint8_t>(faults_.random().next_u32());
  if (effect.lost) return {};
  last_ready_ = meta.ready = std::max(meta.ready + effect.delay, last_ready_);
  for (int copies = effect.duplicated ? 2 : 1; copies > 0; --copies) {
    if (effect.delay.count() > 0 || !held_.empty())
      held_.push_back({drawn_, meta});
    else if (auto sent = send(drawn_, meta); !sent)
      return sent;
  }
  return {};
}

hal::Status FrameFaults::release(hal::Time until, const Send& send) {
  for (; !held_.empty() && held_.front().meta.ready <= until; held_.pop_front())
    if (auto sent = send(held_.front().pixels, held_.front().meta); !sent) return sent;
  return {};
}

/// The edge that becomes free repeats the picture's own edge.
void FrameFaults::move_right(double share) {
  const auto units = static_cast<int>(row_bytes_ / unit_bytes_);
  const auto by = static_cast<int>(share * units);
  std::vector<std::uint8_t> row(row_bytes_);
  for (std::uint32_t y = 0; y < height_; ++y) {
    std::uint8_t* at = drawn_.data() + std::size_t{y} * row_bytes_;
    for (int x = 0; x < units; ++x) {
      const auto from = static_cast<std::size_t>(std::clamp(x - by, 0, units - 1));
      std::memcpy(row.data() + static_cast<std::size_t>(x) * unit_bytes_, at + from * unit_bytes_, unit_bytes_);
    }
    std::memcpy(at, row.data(), row_bytes_);
  }
}

}  // namespace sinew::plant
