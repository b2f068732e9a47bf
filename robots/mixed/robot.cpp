#include "robots/mixed/devices.hpp"
#include "robots/mixed/finder.hpp"
#include "robots/mixed/orange_ball.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_mixed_modules(rt::ModuleTypes& types) {
  types.add<mixed::Finder>("mixed::Finder");
  types.add<mixed::OrangeBall>("mixed::OrangeBall");
}

constexpr PhaseWords kMixedPhases[] = {
    {"mixed::Finder", msg::MissionPhase::wait, "getting on its feet"},
    {"mixed::Finder", msg::MissionPhase::search, "looking for the object"},
    {"mixed::Finder", msg::MissionPhase::hold, "watching the object"},
};

}  // namespace

RobotKind describe_mixed();
RobotKind describe_mixed() { return {add_mixed_modules, plant::mixed_world(), kMixedPhases}; }

}  // namespace sinew::robots
