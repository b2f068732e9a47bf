#pragma once
#include "hal/connectors.hpp"

namespace sinew::hal {

/// One chip select of the kernel's SPI, "/dev/spidev0.0", eight bits a word.
/// Errors:  bad_argument (mode, clock), not_found, denied, not_supported, io; `why` has it in words.
Result<std::unique_ptr<SpiBus>> open_spi(const SpiSpec& spec, std::string& why);

}  // namespace sinew::hal
