#pragma once
// The `status` reply of a robot's socket (docs/robot-socket.md) as text. The reply comes from another program: a value
// that is missing or of another type shows as 0 or empty.
#include <string>

#include "apps/live/live_robot.hpp"
#include "apps/view/status_table.hpp"

namespace sinew::app {

/// One screen: everything that needs attention, and counts of the rest. `all` has the members of `hello`, too.
std::string status_text(const Json& all);

/// One line a module.
std::string module_table(const Json& status);

/// For a StatusTable.
StatusRows rows_of(const Json& status);

}  // namespace sinew::app
