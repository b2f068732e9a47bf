#pragma once
#include "hal/linux/can/can_counters.hpp"

namespace sinew::hal {

/// Counts what an error frame reports about the controller: its state, its error counters, frames that it lost. A
/// "restarted" frame brings the state back to active.
/// RT:      yes.
/// Source:  linux/can/error.h; Documentation/networking/can.rst, "RAW socket option CAN_RAW_ERR_FILTER".
void count_error_frame(const msg::CanFrame& frame, CanCounters& counters) noexcept;

}  // namespace sinew::hal
