#pragma once
#include <memory>
#include <string>

#include "hal/buses.hpp"

namespace sinew::hal {

/// An I2C bus of the kernel, "/dev/i2c-1". Combined transfers (I2C_RDWR) where the adapter can do them. On an adapter
/// that only speaks SMBus (i2c-stub, many PC chips) register reads go in blocks of 32 bytes, each from the register
/// where the last one ended; so one read cannot empty a FIFO register there.
/// Thread:  the bus may be used by several threads; each transfer is whole.
/// Errors:  not_found, denied, not_supported (no bus), io; `why` has it in words. Of transfers: not_found when nothing
///          answers at the address, busy when a kernel driver holds it (SMBus only), bad_argument, closed, timeout, io.
Result<std::unique_ptr<I2cBus>> open_i2c(const std::string& path, std::string& why);

}  // namespace sinew::hal
