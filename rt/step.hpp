#pragma once
#include <cstdint>

#include "math/random.hpp"
#include "msg/time.hpp"

namespace sinew::rt {

using msg::Duration;
using msg::Time;

/// How a step ended. ok commits its loans together; anything else discards them.
enum class StepStatus : std::uint8_t {
  ok,     // outputs are published (also when nothing was loaned)
  stale,  // an input that the step needs is missing or too old: normal, counted
  fault,  // the step could not do its work: counted; repeated faults stop the module
};

class ZoneLog;

/// All that a step may know besides its inputs, parameters and own state. A step calls no clock, takes no lock,
/// allocates nothing and touches no file, device or thread.
struct Step {
  Time now;              // instant of the latch, on the executor's clock
  Duration dt;           // release to release of the thread for periodic threads, else since the last release; never 0
  bool timed_out;        // the thread was released by its time-out, not by its trigger
  std::uint32_t number;  // steps of this module since the start or the last reset, from 0
  math::Random& random;  // seeded by run, module and step: the same step gets the same numbers
  ZoneLog* zones = nullptr;  // for rt::Zone alone; null: no reader asks for zones
};

}  // namespace sinew::rt
