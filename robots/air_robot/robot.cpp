#include "robots/air_robot/devices.hpp"
#include "robots/air_robot/hop.hpp"
#include "robots/air_robot/steer.hpp"
#include "robots/air_robot/steer_to.hpp"
#include "robots/air_robot/text_pose.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::robots {
namespace {

void add_air_robot_modules(rt::ModuleTypes& types) {
  types.add<air_robot::TextPose>("air_robot::TextPose");
  types.add<air_robot::Hop>("air_robot::Hop");
  types.add<air_robot::Steer>("air_robot::Steer");
  types.add<air_robot::SteerTo>("air_robot::SteerTo");
}

constexpr PhaseWords kAirRobotPhases[] = {
    {"air_robot::SteerTo", msg::MissionPhase::search, "searching the target"},
    {"air_robot::SteerTo", msg::MissionPhase::approach, "steering to the target"},
    {"air_robot::SteerTo", msg::MissionPhase::hold, "staying over the target"},
    {"air_robot::Hop", msg::MissionPhase::search, "looking round"},
    {"air_robot::Hop", msg::MissionPhase::approach, "going forward"},
    {"air_robot::Hop", msg::MissionPhase::hold, "staying where it is"},
};

}  // namespace

RobotKind describe_air_robot();
RobotKind describe_air_robot() {
  using namespace plant;
  return {add_air_robot_modules, {"air_robot", kAirRobotDevices, kAirRobotWorldOptions, kMostRobots}, kAirRobotPhases};
}

}  // namespace sinew::robots
