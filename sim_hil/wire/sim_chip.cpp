#include "sim_hil/wire/sim_chip.hpp"

#include <algorithm>

namespace sinew::sim_hil {

void SimChip::read_from(std::uint8_t first, std::span<std::uint8_t> into) {
  for (std::uint8_t& b : into) {
    b = on_read(first);
    if (!is_fifo(first)) ++first;
  }
}

void SimChip::write_to(std::uint8_t first, std::span<const std::uint8_t> values) {
  for (const std::uint8_t v : values) on_write(first++, v);
}

hal::Status SimI2cBus::transfer(std::uint8_t address, std::span<const std::uint8_t> write,
                                std::span<std::uint8_t> read) noexcept {
  transfers.add();
  const BusFault now = fault;
  if (now == BusFault::errors) return hal::Error{hal::Errc::io, "simulated", 5};
  if (now == BusFault::gone) return hal::Error{hal::Errc::closed, "simulated", 19};
  const auto chip = chips_.find(address);
  if (now == BusFault::no_answer || chip == chips_.end() || write.empty())
    return hal::Error{hal::Errc::not_found, "simulated", 6};
  const auto lock = chip->second->lock();
  if (write.size() > 1) chip->second->write_to(write[0], write.subspan(1));
  if (const int cut = cut_next_after; cut >= 0 && read.size() > static_cast<std::size_t>(cut)) {
    cut_next_after = -1;
    chip->second->read_from(write[0], read.first(static_cast<std::size_t>(cut)));
    return hal::Error{hal::Errc::io, "simulated", 5};
  }
  chip->second->read_from(write[0], read);
  if (now == BusFault::held_high) std::fill(read.begin(), read.end(), std::uint8_t{0xFF});
  if (now == BusFault::held_low) std::fill(read.begin(), read.end(), std::uint8_t{0});
  return {};
}

hal::Status SimSpiDevice::transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept {
  const auto lock = chip_->lock();
  if (out[0] & 0x80) {
    if (!in.empty()) in[0] = 0;
    if (in.size() > 1) chip_->read_from(out[0] & 0x7F, in.subspan(1));
  } else {
    chip_->write_to(out[0], out.subspan(1));
  }
  return {};
}

}  // namespace sinew::sim_hil
