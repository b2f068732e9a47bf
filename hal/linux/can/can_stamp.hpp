#pragma once
// Receive times of the kernel and of controllers, on the clock of the runtime.
#include <ctime>

#include "hal/os.hpp"

namespace sinew::hal {

/// The runtime's clock, the wall clock and the runtime's again, read one after the other: how far apart the two clocks
/// are is known to within `after - before`, however long the thread was kept waiting in between.
struct ClockReading {
  Time before;
  std::int64_t realtime_ns = 0;
  Time after;
};

/// Thread:  any.   RT: yes.
ClockReading read_clocks(Os& os) noexcept;

/// Since the epoch of its clock.
inline std::int64_t ns_of(const std::timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

/// The kernel stamps frames with wall time, which may be set while they wait in the socket. What the two clocks differ
/// by is looked up with every batch and narrowed by each reading that contradicts none before it; both are steered
/// alike, so only a wall clock that was set contradicts. A stamp that would be in the future, or before the socket was
/// last seen empty, is tried with what they differed by before, and is else the time of reading.
/// Thread:  owner.   RT: yes.
class RealtimeStamps {
 public:
  /// `empty_at`: nothing was in the socket at that time (when it was opened).
  explicit RealtimeStamps(Time empty_at) : floor_(empty_at) {}
  /// A batch was read before `clocks` were.
  void begin(const ClockReading& clocks) noexcept;
  /// Nothing was in the socket at some time after `asked`.
  void drained(Time asked) noexcept { floor_ = asked; }
  /// Between the time at which the socket was last seen empty and `ClockReading::before` of this batch.
  Time convert(std::int64_t realtime_ns) const noexcept;

 private:
  struct Offset {  // wall time less the runtime's time
    std::int64_t least = 0, most = 0;
  };
  bool fits(std::int64_t realtime_ns, const Offset& offset, Time& out) const noexcept;

  Time floor_, now_;
  Offset offset_, offset_before_;
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
