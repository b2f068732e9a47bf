#include "robots/desk_head/devices.hpp"
#include "robots/desk_head/head_follower.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_modules(rt::ModuleTypes& types) { types.add<control::HeadFollower>("control::HeadFollower"); }

}  // namespace

RobotKind describe_desk_head();
RobotKind describe_desk_head() { return {add_modules, {"desk_head", plant::kHeadDevices, plant::kHeadWorldOptions}}; }

}  // namespace sinew::robots
