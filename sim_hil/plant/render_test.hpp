#pragma once
#include <cstdint>
#include <string>

namespace sinew::plant {

/// Writes pictures of the world into a folder (as PNG) and measures how long a camera frame takes. What
/// `sinew-sim --render-test` does. Returns an exit code.
int render_test(const std::string& folder, std::uint32_t width, std::uint32_t height);

}  // namespace sinew::plant
