#pragma once
// Receive times of the kernel, converted to the clock of the runtime.
#include <ctime>

#include "hal/os.hpp"

namespace sinew::hal {

/// The runtime's clock, the wall clock and the runtime's again, read one after the other. This bounds the difference of
/// the two clocks to within `after - before`, however long the thread had to wait in between.
struct ClockReading {
  Time before;
  std::int64_t realtime_ns = 0;
  Time after;
  double rate = 1;  // of the runtime's clock beside the wall clock
};

/// Thread:  any.   RT: yes.
ClockReading read_clocks(Os& os) noexcept;

/// Since the epoch of its clock.
inline std::int64_t ns_of(const std::timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

/// The kernel stamps frames and datagrams with wall time, which may be set while they wait in the socket. Each batch
/// measures the difference of the two clocks, and each reading that contradicts no earlier one narrows it; both clocks
/// are steered alike, so only a wall clock that was set contradicts; the pace of a runtime that has another one is
/// known. If a stamp would be in the future, or before the socket was last seen empty, the previous difference is
/// tried; if that fails too, the time of reading is used.
/// Thread:  owner.   RT: yes.
class RealtimeStamps {
 public:
  /// `empty_at`: the socket was empty at that time (when it was opened).
  explicit RealtimeStamps(Time empty_at) : floor_(empty_at) {}
  /// A batch was read before `clocks` were.
  void begin(const ClockReading& clocks) noexcept;
  /// The socket was empty at some time after `asked`.
  void drained(Time asked) noexcept { floor_ = asked; }
  /// Between the time at which the socket was last seen empty and `ClockReading::before` of this batch.
  Time convert(std::int64_t realtime_ns) const noexcept;

 private:
  struct Offset {  // wall time, at the runtime's pace, less the runtime's time
    std::int64_t least = 0, most = 0;
  };
  std::int64_t paced(std::int64_t realtime_ns) const noexcept;
  bool fits(std::int64_t paced_ns, const Offset& offset, Time& out) const noexcept;

  Time floor_, now_;
  Offset offset_, offset_before_;
  std::int64_t first_ns_ = 0;  // the wall time that was read first: paces meet there
  double rate_ = 1;
  bool begun_ = false;
};

}  // namespace sinew::hal
