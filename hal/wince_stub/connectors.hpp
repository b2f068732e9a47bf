#pragma once
#include "hal/connectors.hpp"

namespace sinew::hal {

/// The connectors of a Windows CE board: none is known, each says so (not_supported). A port to a board writes them
/// here.
/// Thread:  owner, configure only.
std::unique_ptr<Connectors> wince_connectors();

}  // namespace sinew::hal
