#pragma once
// The `status` reply of a robot's socket (docs/robot-socket.md) as text. What a reply lacks or has of another kind
// shows as 0 or empty: it comes from another program.
#include <string>

#include "apps/live/live_robot.hpp"
#include "apps/view/status_table.hpp"

namespace sinew::app {

/// One screen: what needs attention, and that the rest is well. `all` has the members of `hello`, too.
std::string status_text(const Json& all);

/// One line a module.
std::string module_table(const Json& status);

/// For a StatusTable.
StatusRows rows_of(const Json& status);

}  // namespace sinew::app
