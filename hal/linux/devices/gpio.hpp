#pragma once
#include "hal/connectors.hpp"

namespace sinew::hal {

/// One line of a GPIO chip, by the kernel's character device (second version of its interface, Linux 5.10). The chip is
/// named by path or label, the line by number or name. Edges carry the kernel's monotonic stamps.
/// Errors:  bad_argument (edges of an output, no such line), not_found, denied, busy (a driver or program holds the
///          line), not_supported, io; `why` has it in words.
Result<std::unique_ptr<Gpio>> open_gpio(const GpioSpec& spec, std::string& why);

}  // namespace sinew::hal
