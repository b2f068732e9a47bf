#pragma once
#include "hal/os.hpp"

namespace sinew::hal {

/// The Linux kernel as the runtime's operating system: CLOCK_MONOTONIC, SCHED_FIFO, private futexes, memfd.
/// Thread:  any.
Os& linux_os();

}  // namespace sinew::hal
