#pragma once
#include <memory>
#include <string>

#include "hal/watchdog.hpp"

namespace sinew::hal {

/// Opens the kernel's watchdog interface ("/dev/watchdog") and asks for a timeout in whole seconds, rounded up. A file
/// that is no device (a pipe of a test) gets the same writes and keeps the timeout that was asked for.
/// Errors:  not_found, denied, busy (another process feeds it), bad_argument: a timeout below 1 s; io.
/// Source:  Linux, Documentation/watchdog/watchdog-api.rst: any write feeds, 'V' before the close disarms.
Result<std::unique_ptr<Watchdog>> open_watchdog(const std::string& path, Duration timeout);

}  // namespace sinew::hal
