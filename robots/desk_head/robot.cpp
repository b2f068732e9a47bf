#include "robots/desk_head/devices.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {

RobotKind describe_desk_head();
RobotKind describe_desk_head() { return {{}, {"desk_head", plant::kHeadDevices, plant::kHeadWorldOptions}}; }

}  // namespace sinew::robots
