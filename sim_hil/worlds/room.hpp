#pragma once
#include <memory>
#include <string_view>

#include "hal/result.hpp"
#include "sim_hil/worlds/world.hpp"

struct mjModel_;
struct mjData_;

namespace sinew::plant {

struct MujocoDelete {
  void operator()(mjModel_* m) const;
  void operator()(mjData_* d) const;
};
using ModelPtr = std::unique_ptr<mjModel_, MujocoDelete>;
using DataPtr = std::unique_ptr<mjData_, MujocoDelete>;

/// The text of robots/quad_room.xml or robots/desk_head_room.xml, built in.
std::string_view room_xml(WorldKind world);

enum class RoomUse {
  physics,
  pictures
};  // physics leaves out what only pictures need: a third of the time per step is left

/// Compiles the room. What MuJoCo has to say about a wrong file goes to stderr.
/// Thread:  one at a time (the compiler of MuJoCo keeps globals).
/// Errors:  bad_data.
hal::Result<ModelPtr> load_room(WorldKind world, RoomUse use);

/// Paints the textures of floor, walls, pad and the rest, as far as the model has them: code instead of image files,
/// integers only, the same bytes everywhere. Needed for rendering only.
void paint_room(mjModel_& model);

}  // namespace sinew::plant
