#pragma once
#include <cstdint>
#include <span>

#include "hal/device.hpp"
#include "msg/can.hpp"

namespace sinew::hal {

/// State of a controller on its bus (ISO 11898-1: fault confinement).
enum class CanState : std::uint8_t { active, warning, passive, bus_off, stopped };
const char* to_string(CanState state);

/// Everything is counted since the bus was opened.
struct CanStats {
  CanState state = CanState::active;
  std::uint64_t received = 0, sent = 0;            // frames, without error frames
  std::uint64_t received_bits = 0, sent_bits = 0;  // on the wire, worst-case stuffing: for the bus load
  std::uint64_t rx_lost = 0;  // received by the kernel or controller, and dropped before we read them
  std::uint64_t tx_lost = 0;  // deadline passed, no room, or refused
  std::uint64_t error_frames = 0, bus_offs = 0, restarts = 0;
  std::uint64_t malformed = 0;                // a transport received it and could not understand it
  std::uint8_t tx_errors = 0, rx_errors = 0;  // the controller's own counters, where it gives them
};

/// Frames whose identifier agrees with `id` in all bits of `mask` are received.
struct CanFilter {
  std::uint32_t id = 0, mask = 0;
  bool extended = false;
};

/// One CAN bus: SocketCAN, or another transport of CAN frames. The bus's one driver (drivers::CanHub) is its only
/// reader and distributes the frames: devices never read the bus.
/// Thread:  read() and wait on one thread, send() on one thread; they may differ.
/// RT:      read() and send() never block.
class CanBus {
 public:
  virtual ~CanBus() = default;
  /// Moves the oldest received frame into `out`, error frames too. False: nothing is there (normal).
  /// Errors:  closed when the interface or peer is gone for now; the bus comes back without a call, and later calls
  ///          succeed.
  virtual Result<bool> read(msg::CanFrame& out) noexcept = 0;
  /// Queues a frame without waiting. A frame that has not begun to leave by `deadline` is dropped and counted, as far
  /// as the transport can take it back; kNever: no deadline.
  /// Errors:  timeout: no room, or `deadline` is over; closed: no bus, or bus-off; bad_argument: no such frame.
  virtual Status send(const msg::CanFrame& frame, Time deadline) noexcept = 0;
  /// Only matching frames are received from now on; empty: all frames. Errors: not_supported, io.
  virtual Status set_filters(std::span<const CanFilter> filters) = 0;
  /// `wake` is woken when a frame was received; see Device::set_wake().
  virtual void set_wake(Wake* wake) noexcept = 0;
  virtual CanStats stats() const noexcept = 0;
  /// Nominal bit rate, for the bus load; 0: none (a transport without bits).
  virtual std::uint32_t bit_rate() const noexcept = 0;
};

/// Bits of a frame on the wire, with the most stuff bits that its length can have and the interframe space.
/// Source:  ISO 11898-1; K. Tindell, A. Burns, "Guaranteeing message latencies on controller area network", ICC 1994.
/// For CAN FD the data phase is counted in nominal bits (`data_rate_ratio` = data bit rate / nominal bit rate).
std::uint32_t can_frame_bits(const msg::CanFrame& frame, double data_rate_ratio = 1.0) noexcept;

}  // namespace sinew::hal
