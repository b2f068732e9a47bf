#pragma once
// Every message type of Sinew, for the command line, documentation and tests. Modules include only the messages that
// they use.
#include <span>
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

/// In order of name. RT: configure only.
std::span<const TypeInfo* const> all_types();

/// Also FromMate<...> of all types without pixels ("NavStateFromMate"), with the layout of type_info<FromMate<...>>()
/// in an object of its own. Null when no message has this name. RT: configure only.
const TypeInfo* find_type(std::string_view name);

}  // namespace sinew::msg
