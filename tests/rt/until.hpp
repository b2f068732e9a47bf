#pragma once
// Waiting for other threads.
#include "hal/platform.hpp"

namespace sinew::rt {

/// False after a minute, which fails the test that asked. Sleeps through the Os, by its clock: threads of the C++
/// library do not sleep at all for less than a millisecond where that library is winpthreads.
template <class Condition>
bool until(Condition&& condition) {
  hal::Os& os = hal::system_os();
  const hal::Time end = os.now() + std::chrono::minutes(1);
  while (!condition()) {
    if (os.now() >= end) return false;
    os.sleep_until(os.now() + std::chrono::microseconds(200));
  }
  return true;
}

}  // namespace sinew::rt
