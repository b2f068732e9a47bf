#pragma once
#include <string>

namespace sinew::hal {

/// Reports of a device, a bus or its opener in words, besides its measurements. The owner of a hal::CanBus, Imu or
/// Camera asks with dynamic_cast, as for CameraControls.
class SelfReport {
 public:
  virtual ~SelfReport() = default;
  /// What is wrong now, one complaint a line; empty: nothing. The words stay the same while the trouble lasts: no
  /// counters, no times.
  /// Thread:  any.   RT: no (may lock, allocates).
  virtual std::string trouble() const = 0;
  /// Requests that were refused: SCHED_FIFO or a processor for its own threads, a kernel's buffer. Does not change any
  /// more once it runs.
  virtual std::string shortfall() const { return {}; }
};

}  // namespace sinew::hal
