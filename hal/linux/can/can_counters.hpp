#pragma once
#include <atomic>
#include <span>

#include "hal/can_bus.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// CanStats while a reader, a sender and a keeper count.   Thread: any.   RT: yes.
/// All relaxed: each number is independent, and no thread waits for one.
class CanCounters {
 public:
  explicit CanCounters(double data_rate_ratio = 1) : ratio_(data_rate_ratio) {}
  void received(const msg::CanFrame& frame) noexcept {
    add(received_), add(received_bits_, can_frame_bits(frame, ratio_));
  }
  void sent(const msg::CanFrame& frame) noexcept { add(sent_), add(sent_bits_, can_frame_bits(frame, ratio_)); }
  void rx_lost(std::uint32_t n = 1) noexcept { add(rx_lost_, n); }
  void tx_lost() noexcept { add(tx_lost_); }
  void malformed(std::uint32_t n = 1) noexcept { add(malformed_, n); }
  void error_frame() noexcept { add(error_frames_); }
  std::uint64_t error_frames() const noexcept { return error_frames_.value(); }
  void set_errors(std::uint8_t tx, std::uint8_t rx) noexcept {
    tx_errors_.store(tx, std::memory_order_relaxed), rx_errors_.store(rx, std::memory_order_relaxed);
  }
  /// Counts transitions: into bus-off, and out of it.
  void set_state(CanState state) noexcept {
    const CanState before = state_.exchange(state, std::memory_order_relaxed);
    if (before != CanState::bus_off && state == CanState::bus_off) add(bus_offs_);
    if (before == CanState::bus_off && state != CanState::bus_off && state != CanState::stopped) add(restarts_);
  }
  CanState state() const noexcept { return state_.load(std::memory_order_relaxed); }
  CanStats snapshot() const noexcept {
    CanStats out;
    out.state = state();
    out.received = get(received_), out.sent = get(sent_);
    out.received_bits = get(received_bits_), out.sent_bits = get(sent_bits_);
    out.rx_lost = get(rx_lost_), out.tx_lost = get(tx_lost_);
    out.error_frames = get(error_frames_), out.bus_offs = get(bus_offs_), out.restarts = get(restarts_);
    out.malformed = get(malformed_);
    out.tx_errors = tx_errors_.load(std::memory_order_relaxed),
    out.rx_errors = rx_errors_.load(std::memory_order_relaxed);
    return out;
  }

 private:
  static void add(Tally& tally, std::uint32_t n = 1) noexcept { tally.add(n); }
  static std::uint64_t get(const Tally& tally) noexcept { return tally.value(); }

  const double ratio_;
  Tally received_, sent_, received_bits_, sent_bits_, rx_lost_, tx_lost_;
  Tally error_frames_, bus_offs_, restarts_, malformed_;
  std::atomic<CanState> state_{CanState::active};
  std::atomic<std::uint8_t> tx_errors_{0}, rx_errors_{0};
};

/// True if one of them lets the frame through; no filters: all pass. For transports without filters of their own.
inline bool passes(std::span<const CanFilter> filters, const msg::CanFrame& frame) noexcept {
  if (filters.empty() || frame.error()) return true;
  for (const CanFilter& f : filters)
    if (f.extended == frame.extended() && (frame.id & f.mask) == (f.id & f.mask)) return true;
  return false;
}

}  // namespace sinew::hal
