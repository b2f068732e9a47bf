#pragma once
#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// A hardware watchdog: resets the machine when it is not fed. It runs from the moment it is opened.
/// Thread:  owner.
/// Owner:   the destructor does not disarm: for the watchdog a process that ends without release() has died.
class Watchdog {
 public:
  virtual ~Watchdog() = default;
  /// Feed it at most timeout() after the last time. Errors: io.
  virtual Status feed() noexcept = 0;
  /// The device's timeout; the requested one when the device does not say.
  virtual Duration timeout() const noexcept = 0;
  /// Disarms it, for an orderly end. Errors: io; devices that cannot be stopped run on all the same.
  virtual Status release() noexcept = 0;
};

}  // namespace sinew::hal
