#pragma once
// A CAN bus in memory: all other ports receive what one port sends; bits are counted.
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "hal/can_bus.hpp"
#include "hal/wake_slot.hpp"

namespace sinew::sim_hil {

class MemoryCanPort;

/// The wire between ports. Frames arrive at once, in the order in which they were sent; time is the clock's.
/// Thread:  any (a lock, held for a copy): for tests and simulators, not for a robot.
class MemoryCan {
 public:
  /// Without a clock frames carry no time stamp.
  explicit MemoryCan(std::uint32_t bit_rate = 1'000'000, const hal::Clock* clock = nullptr)
      : bit_rate_(bit_rate), clock_(clock) {}
  MemoryCan(const MemoryCan&) = delete;
  MemoryCan& operator=(const MemoryCan&) = delete;

  /// One more node. Before frames go. Owner: this.
  MemoryCanPort& attach();
  /// Which frames are lost on the way: true drops one. Called under the lock. Set before frames go, or null.
  void lose(std::function<bool(const msg::CanFrame&)> drops);
  /// False: the bus is gone for every port, until it is back.
  void connect(bool connected);

  std::uint64_t bits() const;
  std::uint64_t frames() const;
  std::uint32_t bit_rate() const { return bit_rate_; }

 private:
  friend class MemoryCanPort;
  hal::Status transmit(const MemoryCanPort& from, msg::CanFrame frame);

  const std::uint32_t bit_rate_;
  const hal::Clock* clock_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<MemoryCanPort>> ports_;
  std::function<bool(const msg::CanFrame&)> drops_;
  bool connected_ = true;
  std::uint64_t bits_ = 0, frames_ = 0;
};

/// One node's controller. As hal::CanBus; its queue holds 4096 frames, further ones are lost and counted.
class MemoryCanPort final : public hal::CanBus {
 public:
  explicit MemoryCanPort(MemoryCan& wire) : wire_(wire) {}
  hal::Result<bool> read(msg::CanFrame& out) noexcept override;
  hal::Status send(const msg::CanFrame& frame, hal::Time deadline) noexcept override;
  hal::Status set_filters(std::span<const hal::CanFilter> filters) override;
  void set_wake(hal::Wake* wake) noexcept override { wake_.change(wake); }
  hal::CanStats stats() const noexcept override;
  std::uint32_t bit_rate() const noexcept override { return wire_.bit_rate(); }

 private:
  friend class MemoryCan;
  static constexpr std::size_t kQueue = 4096;
  bool wants(const msg::CanFrame& frame) const;

  MemoryCan& wire_;
  std::deque<msg::CanFrame> queue_;  // wire_.mutex_
  std::vector<hal::CanFilter> filters_;
  hal::CanStats stats_;
  hal::WakeSlot wake_;
};

}  // namespace sinew::sim_hil
