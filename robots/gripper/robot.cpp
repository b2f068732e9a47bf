#include "robots/gripper/devices.hpp"
#include "robots/gripper/fetch.hpp"
#include "robots/gripper/field_place.hpp"
#include "robots/gripper/wheels.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_gripper_modules(rt::ModuleTypes& types) {
  types.add<gripper::Wheels>("gripper::Wheels");
  types.add<gripper::Fetch>("gripper::Fetch");
  types.add<gripper::FieldPlace>("gripper::FieldPlace");
}

constexpr PhaseWords kGripperPhases[] = {
    {"gripper::Fetch", msg::MissionPhase::wait, "standing"},
    {"gripper::Fetch", msg::MissionPhase::search, "looking for the ball"},
    {"gripper::Fetch", msg::MissionPhase::approach, "driving to the ball"},
    {"gripper::Fetch", msg::MissionPhase::hold, "closing the gripper"},
    {"gripper::Fetch", msg::MissionPhase::descend, "carrying the ball"},
    {"gripper::Fetch", msg::MissionPhase::touchdown, "letting go"},
};

}  // namespace

RobotKind describe_gripper();
RobotKind describe_gripper() {
  return {add_gripper_modules, {"gripper", plant::kGripperDevices, plant::gripper_options()}, kGripperPhases};
}

}  // namespace sinew::robots
