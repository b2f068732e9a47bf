#pragma once
#include <string>

namespace sinew::app {

/// Sets the environment of programs that this process starts from now on: libsinew_grab.so is loaded into them, it is a
/// Vulkan layer, and it finds the session at `socket`. What the user has in these variables stays.
/// False: `why` says in words what is missing.
bool set_grab_environment(const std::string& socket, bool buffered, std::string& why);

}  // namespace sinew::app
