#pragma once
#include <string>
#include <string_view>

namespace sinew::monitor {

/// A decoded path as clients of ours ask for: begins with '/', printable, no "." and "..", no empty part but the last,
/// no backslash.
bool is_plain_path(std::string_view path);

}  // namespace sinew::monitor
