#include "robots/robot_kind.hpp"
#include "robots/terrain/devices.hpp"

namespace sinew::robots {

RobotKind describe_terrain();
RobotKind describe_terrain() { return {nullptr, {"terrain", plant::kQuadDevices, plant::kTerrainWorldOptions}}; }

}  // namespace sinew::robots
