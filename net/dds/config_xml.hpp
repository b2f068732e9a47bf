#pragma once
#include <string>

#include "net/dds/participant.hpp"

namespace sinew::net {

/// Why Cyclone need not be asked; empty: the options are possible.
std::string problem_of(const ParticipantOptions& options);

/// The options in the words of Cyclone's configuration.
std::string config_xml(const ParticipantOptions& options);

}  // namespace sinew::net
