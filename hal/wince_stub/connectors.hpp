#pragma once
#include "hal/connectors.hpp"

namespace sinew::hal {

/// The plugs of a Windows CE board: none is known, each says so (not_supported). Whoever ports to one writes them here.
/// Thread:  owner, configure only.
std::unique_ptr<Connectors> wince_connectors();

}  // namespace sinew::hal
