#pragma once
#include <memory>
#include <string>

#include "hal/connectors.hpp"
#include "hal/linux/fd_watch.hpp"

namespace sinew::hal {

/// Opens a CAN bus of any transport: SocketCanBus, UdpCanBus or SocketcandCan; their headers describe them. `why` has
/// an error in words, with the remedy; after success it is empty or says what will be missing.
/// Errors:  bad_argument: no such transport or address; those of each open().
Result<std::unique_ptr<CanBus>> open_can(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch, std::string& why);

}  // namespace sinew::hal
