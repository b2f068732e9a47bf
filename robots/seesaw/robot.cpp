#include "robots/robot_kind.hpp"
#include "robots/seesaw/balance.hpp"
#include "robots/seesaw/devices.hpp"

namespace sinew::robots {

RobotKind describe_seesaw();
RobotKind describe_seesaw() {
  return {[](rt::ModuleTypes& types) { types.add<Balance>("seesaw::Balance"); },
          {"seesaw", plant::kSeesawDevices, plant::kSeesawWorldOptions}};
}

}  // namespace sinew::robots
