#pragma once
#include <string>

#include "hal/result.hpp"

namespace sinew::hal {

/// A way to the actuators around the runtime: a supervisor stops the actuators with it when the runtime is dead. It is
/// opened beforehand, while all is well.
class StopLine {
 public:
  virtual ~StopLine() = default;
  /// Stops all actuators for good. Ok: the devices have confirmed.
  /// Thread:  owner.   RT: allocates nothing; waits for the answer, bounded.
  /// Errors:  closed when no device is left to stop; timeout when none answered (the stop has been sent); io.
  virtual Status stop() noexcept = 0;
  /// True if the devices keep the stop. False: a later command undoes the stop, so send it (again) when the runtime is
  /// dead.
  virtual bool is_latching() const noexcept { return true; }
  /// Call every few milliseconds while all is well: takes what has come on the line. Thread: owner. RT: yes.
  virtual void poll() noexcept {}
  /// The result of the last stop(), in words; empty: its status says it all. Thread: owner. RT: no.
  virtual std::string last_report() const { return {}; }
};

}  // namespace sinew::hal
