#include "robots/quad/devices.hpp"
#include "robots/quad/learned_landing.hpp"
#include "robots/quad/mission.hpp"
#include "robots/quad/pilot_switch.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_modules(rt::ModuleTypes& types) {
  types.add<control::LearnedLanding>("control::LearnedLanding");
  types.add<control::Mission>("control::Mission");
  types.add<control::PilotSwitch>("control::PilotSwitch");
}

constexpr PhaseWords kQuadPhases[] = {
    {"control::Mission", msg::MissionPhase::search, "searching the pad"},
    {"control::Mission", msg::MissionPhase::approach, "approaching the pad"},
    {"control::Mission", msg::MissionPhase::hold, "holding above the pad"},
};

}  // namespace

RobotKind describe_quad();
RobotKind describe_quad() {
  return {add_modules, {"quad", plant::kQuadDevices, plant::kQuadWorldOptions, plant::kMostQuads}, kQuadPhases};
}

}  // namespace sinew::robots
