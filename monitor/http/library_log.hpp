#pragma once
// libwebsockets says only in its log why something failed. Inside of the room only.
#include <string>

namespace sinew::monitor {

/// From now on the library's errors go to last_error(), and nothing of its log to the terminal.
void keep_library_errors();

/// The newest error of this thread, in one line; whoever reads it may clear it.
std::string& last_error();

}  // namespace sinew::monitor
