#pragma once
// Receive times of CAN controllers, converted to the clock of the runtime.
#include "hal/clock.hpp"

namespace sinew::hal {

/// Stamps of a controller's own clock, of which only the rate is known. The smallest difference between the kernel's
/// stamp and the controller's within the last one to two seconds is the shortest way into the kernel. The result is
/// late by that much, plus up to two seconds' drift of the clocks. It is never later than the kernel's stamp.
/// Thread:  owner.   RT: yes.
class HardwareStamps {
 public:
  Time convert(std::int64_t hardware_ns, Time kernel) noexcept;

 private:
  std::int64_t now_min_ = 0, last_min_ = 0;
  Time window_;
  bool begun_ = false;
};

}  // namespace sinew::hal
