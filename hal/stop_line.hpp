#pragma once
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
};

}  // namespace sinew::hal
