#pragma once
#include <cstddef>
#include <memory>
#include <string_view>

#include "hal/result.hpp"

struct mjModel_;
struct mjData_;

namespace sinew::plant {

struct MujocoDelete {
  void operator()(mjModel_* m) const;
  void operator()(mjData_* d) const;
};
using ModelPtr = std::unique_ptr<mjModel_, MujocoDelete>;
using DataPtr = std::unique_ptr<mjData_, MujocoDelete>;

enum class RoomUse {
  physics,
  pictures
};  // physics leaves out what only pictures need: a third of the time per step is left

/// Compiles a room from its XML (WorldType::room_xml). MuJoCo's words about a wrong file go to stderr.
/// With `robots` above 1 the room's body that hangs on no joint is there as often, one behind the other in bodies,
/// geoms and joints; the names in copy i end with i, from 1 on. A room without such a body moves its robots itself.
/// A height field without a file gets its heights from the custom text of the same name: whole millimetres over its
/// floor, row after row along y, x rising in a row. Thread:  one at a time (the compiler of MuJoCo keeps
/// globals). Errors:  bad_data.
hal::Result<ModelPtr> load_room(std::string_view xml, RoomUse use, std::size_t robots = 1);

}  // namespace sinew::plant
