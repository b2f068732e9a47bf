#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_hil/plant/camera_feed.hpp"

namespace sinew::plant {

/// R, G, B, row after row from the top. Errors: false, with a line on standard error.
bool write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
               const std::vector<std::uint8_t>& rgb);
/// The pose of a camera that looks from a viewpoint at its target, upright.
CameraPose camera_of(const Viewpoint& from);

/// Writes pictures of the view's world into a folder (as PNG) and measures how long a camera frame takes. What
/// `sinew-sim --render-test` does. Returns an exit code.
int render_test(const std::string& folder, const CameraOptions& view, const WorldChoice& choice);

}  // namespace sinew::plant
