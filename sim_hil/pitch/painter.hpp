#pragma once
// Pictures of the pitch for worlds that are made of it: its scenes, and what draws them.
#include <memory>

#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// The ball, then the links of each robot, robot after robot; through this robot's camera, of its body's places whose
/// names begin with "camera", if it has so many.
Scene pitch_scene(const Pitch& pitch, std::size_t robot, std::size_t camera);

/// Draws such scenes. Bodies as given to Pitch::create().
std::unique_ptr<Painter> pitch_painter(std::uint32_t width, std::uint32_t height, const PitchOptions& options,
                                       std::span<const PitchBody> bodies);

}  // namespace sinew::plant
