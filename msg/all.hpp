#pragma once
// Every message type of the house, for the command line, documentation and tests. Modules include what they use
// instead.
#include <span>
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

/// In order of name. RT: configure only.
std::span<const TypeInfo* const> all_types();

/// Null when no message has this name.
const TypeInfo* find_type(std::string_view name);

}  // namespace sinew::msg
