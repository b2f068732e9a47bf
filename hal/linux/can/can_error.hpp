#pragma once
#include "hal/linux/can/can_counters.hpp"

namespace sinew::hal {

/// What an error frame says about the controller: its state, its error counters, frames that it lost. A frame that says
/// "restarted" brings the state back to active.
/// RT:      yes.
/// Source:  linux/can/error.h; Documentation/networking/can.rst, "RAW socket option CAN_RAW_ERR_FILTER".
void count_error_frame(const msg::CanFrame& frame, CanCounters& counters) noexcept;

}  // namespace sinew::hal
