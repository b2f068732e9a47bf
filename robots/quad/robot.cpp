#include "robots/quad/devices.hpp"
#include "robots/quad/mission.hpp"
#include "robots/quad/pilot_switch.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_modules(rt::ModuleTypes& types) {
  types.add<control::Mission>("control::Mission");
  types.add<control::PilotSwitch>("control::PilotSwitch");
}

}  // namespace

RobotKind describe_quad();
RobotKind describe_quad() {
  return {add_modules, {"quad", plant::kQuadDevices, plant::kQuadWorldOptions, plant::kMostQuads}};
}

}  // namespace sinew::robots
