#pragma once
#include <string>

namespace sinew::hal {

/// What a device, a bus or its opener can say about itself in words, beside what it measures. The owner of a
/// hal::CanBus, Imu or Camera asks with dynamic_cast, as for CameraControls.
class SelfReport {
 public:
  virtual ~SelfReport() = default;
  /// What is wrong now, one complaint a line; empty: nothing. Words that stay the same while the trouble does: no
  /// counters, no times.
  /// Thread:  any.   RT: no (may lock, allocates).
  virtual std::string trouble() const = 0;
  /// What it asked for and could not have: SCHED_FIFO or a processor for its own threads, a kernel's buffer. Does not
  /// change any more once it runs.
  virtual std::string shortfall() const { return {}; }
};

}  // namespace sinew::hal
