#pragma once

struct mjModel_;

namespace sinew::plant {

/// Paints the textures of floor, walls, pad and the rest, as far as the model has them: code instead of image files,
/// integers only, the same bytes everywhere. Needed for rendering only.
void paint_room(mjModel_& model);

}  // namespace sinew::plant
