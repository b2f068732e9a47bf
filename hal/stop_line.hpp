#pragma once
#include <string>

#include "hal/result.hpp"

namespace sinew::hal {

/// A way to the actuators that does not lead through the runtime: who watches over it stops them when it is dead.
/// Opened beforehand, while all is well.
class StopLine {
 public:
  virtual ~StopLine() = default;
  /// Stops all actuators for good. Ok: the devices have said that they obey.
  /// Thread:  owner.   RT: allocates nothing; waits for the answer, bounded.
  /// Errors:  closed when there is nobody left to stop; timeout when nobody answered (the stop has been sent); io.
  virtual Status stop() noexcept = 0;
  /// Whether the devices keep the stop. False: a later command undoes it, so that the stop has to be sent when the
  /// runtime is dead, or again then.
  virtual bool is_latching() const noexcept { return true; }
  /// Every few milliseconds while all is well: takes what has come on the line. Thread: owner. RT: yes.
  virtual void poll() noexcept {}
  /// What the last stop() came to, in words; empty: its status says it all. Thread: owner. RT: no.
  virtual std::string last_report() const { return {}; }
};

}  // namespace sinew::hal
