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
  /// Whether the devices remember it. False: whoever sends commands afterwards undoes it, so that it has to be said
  /// when the runtime is dead, or again then.
  virtual bool lasts() const noexcept { return true; }
  /// Now and then while all is well: takes what has come on the line. Thread: owner. RT: yes.
  virtual void tend() noexcept {}
  /// What the last stop() came to, in words; empty: its status says it all. Thread: owner. RT: no.
  virtual std::string told() const { return {}; }
};

}  // namespace sinew::hal
