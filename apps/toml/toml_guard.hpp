#pragma once
#include <string_view>

namespace sinew::app {

/// The first line with a character beyond ASCII outside of a comment, or 0. With some of these characters (U+00B0 is
/// one) toml++ 3.3 runs into code that it has declared unreachable: where TOML allows none and, in a malformed value,
/// inside strings.
int line_beyond_ascii(std::string_view text);

}  // namespace sinew::app
