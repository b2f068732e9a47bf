#include "hal/linux/can/can_stamp.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kJump = 1'000'000'000;

}  // namespace

Time HardwareStamps::convert(std::int64_t hardware_ns, Time kernel) noexcept {
  const std::int64_t difference = kernel.ns - hardware_ns;
  if (!begun_ || std::abs(difference - now_min_) > kJump) {  // the first one, or a clock that was set
    begun_ = true;
    now_min_ = last_min_ = difference;
    window_ = kernel;
  } else if (kernel - window_ > 1s) {
    last_min_ = now_min_;
    now_min_ = difference;
    window_ = kernel;
  }
  now_min_ = std::min(now_min_, difference);
  return {hardware_ns + std::min(now_min_, last_min_)};
}

}  // namespace sinew::hal
