#pragma once
#include <string>

#include "sim_hil/plant/camera_feed.hpp"

namespace sinew::plant {

/// Writes pictures of the view's world into a folder (as PNG) and measures how long a camera frame takes. What
/// `sinew-sim --render-test` does. Returns an exit code.
int render_test(const std::string& folder, const CameraOptions& view, const WorldChoice& choice);

}  // namespace sinew::plant
