#include "sim_hil/wire/memory_can.hpp"

namespace sinew::sim_hil {

MemoryCanPort& MemoryCan::attach() {
  const std::lock_guard lock(mutex_);
  ports_.push_back(std::make_unique<MemoryCanPort>(*this));
  return *ports_.back();
}

void MemoryCan::lose(std::function<bool(const msg::CanFrame&)> drops) {
  const std::lock_guard lock(mutex_);
  drops_ = std::move(drops);
}

void MemoryCan::connect(bool connected) {
  const std::lock_guard lock(mutex_);
  connected_ = connected;
  for (const auto& port : ports_) {
    port->stats_.state = connected ? hal::CanState::active : hal::CanState::stopped;
    if (!connected) port->queue_.clear();
  }
}

std::uint64_t MemoryCan::bits() const {
  const std::lock_guard lock(mutex_);
  return bits_;
}

std::uint64_t MemoryCan::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

hal::Status MemoryCan::transmit(const MemoryCanPort& from, msg::CanFrame frame) {
  {
    const std::lock_guard lock(mutex_);
    if (!connected_) return hal::Error{hal::Errc::closed, "no bus"};
    if (clock_ != nullptr) frame.stamp = clock_->now();
    const std::uint32_t size = hal::can_frame_bits(frame);
    bits_ += size;
    ++frames_;
    if (drops_ && drops_(frame)) return {};  // it was on the wire, but no node got it
    for (const auto& port : ports_) {
      if (port.get() == &from || !port->wants(frame)) continue;
      if (port->queue_.size() >= MemoryCanPort::kQueue) {
        ++port->stats_.rx_lost;
        continue;
      }
      port->queue_.push_back(frame);
      ++port->stats_.received;
      port->stats_.received_bits += size;
    }
  }
  for (const auto& port : ports_) {
    if (port.get() != &from) port->wake_.ring();
  }
  return {};
}

bool MemoryCanPort::wants(const msg::CanFrame& frame) const {
  if (filters_.empty() || frame.error()) return true;
  for (const hal::CanFilter& f : filters_) {
    if (f.extended == frame.extended() && ((frame.id ^ f.id) & f.mask) == 0) return true;
  }
  return false;
}

hal::Result<bool> MemoryCanPort::read(msg::CanFrame& out) noexcept {
  const std::lock_guard lock(wire_.mutex_);
  if (!wire_.connected_) return hal::Error{hal::Errc::closed, "no bus"};
  if (queue_.empty()) return false;
  out = queue_.front();
  queue_.pop_front();
  return true;
}

hal::Status MemoryCanPort::send(const msg::CanFrame& frame, hal::Time) noexcept {
  const hal::Status ok = wire_.transmit(*this, frame);
  const std::lock_guard lock(wire_.mutex_);
  if (!ok) {
    ++stats_.tx_lost;
    return ok;
  }
  ++stats_.sent;
  stats_.sent_bits += hal::can_frame_bits(frame);
  return ok;
}

hal::Status MemoryCanPort::set_filters(std::span<const hal::CanFilter> filters) {
  const std::lock_guard lock(wire_.mutex_);
  filters_.assign(filters.begin(), filters.end());
  return {};
}

hal::CanStats MemoryCanPort::stats() const noexcept {
  const std::lock_guard lock(wire_.mutex_);
  return stats_;
}

}  // namespace sinew::sim_hil
