#pragma once
#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// A hardware watchdog: resets the machine when nobody feeds it. Running from the moment it is opened.
/// Thread:  owner.
/// Owner:   the destructor does not disarm: a process that ends without release() has died as far as it can tell.
class Watchdog {
 public:
  virtual ~Watchdog() = default;
  /// Not later than timeout() after the last one. Errors: io.
  virtual Status feed() noexcept = 0;
  /// As the device has it; what was asked for when it does not say.
  virtual Duration timeout() const noexcept = 0;
  /// Disarms it, for an orderly end. Errors: io; devices built never to stop run on all the same.
  virtual Status release() noexcept = 0;
};

}  // namespace sinew::hal
