#pragma once
// Receive times of the kernel and of controllers, on the clock of the runtime.
#include "hal/clock.hpp"

namespace sinew::hal {

/// The kernel stamps frames with wall time, which may be set while they wait in the socket. What the two clocks differ
/// by is looked up with every batch; a stamp that would be in the future, or before the socket was last seen empty, is
/// tried with what they differed by before, and is else the time of reading.
/// Thread:  owner.   RT: yes.
class RealtimeStamps {
 public:
  /// `empty_at`: nothing was in the socket at that time (when it was opened).
  explicit RealtimeStamps(Time empty_at) : floor_(empty_at) {}
  /// A batch was read at `now`, when the wall clock said `realtime_ns`.
  void begin(Time now, std::int64_t realtime_ns) noexcept;
  /// Nothing is left in the socket.
  void drained() noexcept { floor_ = now_; }
  Time convert(std::int64_t realtime_ns) const noexcept;

 private:
  bool possible(Time t) const noexcept;

  Time floor_, now_;
  std::int64_t offset_ns_ = 0, offset_before_ns_ = 0;
  bool begun_ = false;
};

/// Stamps of a controller's own clock, of which only its rate is known. The smallest difference between the kernel's
/// stamp and the controller's within the last one to two seconds is what the way into the kernel takes at least; that
/// much the result is late, and drift of the clocks adds up to two seconds' worth. Never later than the kernel's stamp.
/// Thread:  owner.   RT: yes.
class HardwareStamps {
 public:
  Time convert(std::int64_t hardware_ns, Time kernel) noexcept;

 private:
  std::int64_t now_min_ = 0, last_min_ = 0;
  Time window_;
  bool begun_ = false;
};

}  // namespace sinew::hal
