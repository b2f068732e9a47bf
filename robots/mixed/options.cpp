#include "robots/gripper/devices.hpp"
#include "robots/kid/devices.hpp"
#include "robots/mixed/devices.hpp"
#include "sim_hil/worlds/air.hpp"
#include "sim_hil/worlds/body_errors.hpp"

namespace sinew::plant {
namespace {

constexpr const char* kWheeled = "wheeled";

constexpr WorldOption kOwn[] = {
    {kWheeled, "wheeled", "", 0, 1, 0.0, "", "1: a robot with wheels and a gripper; 0: a humanoid", true, true},
    {"start_x_m", "start-x", "m", -5, 5, std::nullopt, "by its number", "where the robot starts: along the field",
     false, true},
    {"start_y_m", "start-y", "m", -4, 4, std::nullopt, "by its number", "where the robot starts: across the field",
     false, true},
    {"start_heading_deg", "start-heading", "deg", -180, 180, 0.0, "", "where it looks: 0 along the field", false, true},
    {"servo_gain_per_rad", "servo-gain", "1/rad", 0.5, 100, 4.6, "",
     "what a humanoid's servos are set to: share of the voltage for a radian of error", false, true},
    {"ball_x_m", "ball-x", "m", -4.5, 4.5, std::nullopt, "by the seed, 0.5 to 1.7",
     "where the object is, an orange ball: along the field"},
    {"ball_y_m", "ball-y", "m", -3, 3, std::nullopt, "by the seed, -0.6 to 0.6", "and across the field"},
    {"goal_x_m", "goal-x", "m", -4.5, 4.5, -4.0, "", "where it is to be brought: along the field"},
    {"goal_y_m", "goal-y", "m", -3, 3, 0.0, "", "and across the field"},
    {"wall_high_m", "wall-high", "m", 0, 2, 0.35, "", "height of the wall across the field; 0: there is none"},
    {"wall_x_m", "wall-x", "m", -4.5, 4.5, -0.3, "", "where the wall stands: along the field"},
    {"wall_from_y_m", "wall-from-y", "m", -3, 3, -1.2, "", "it begins here: across the field"},
    {"wall_to_y_m", "wall-to-y", "m", -3, 3, 0.8, "", "and ends here, farther to the left"},
};

}  // namespace

WorldInfo mixed_world_of(const WorldInfo& world, const WorldValues& robot) {
  WorldInfo own = world;
  if (world.value(robot, kWheeled) == 1) {
    own.devices = kGripperDevices;
    own.has_bodies = false;
  }
  return own;
}

WorldInfo mixed_world() {
  static const std::vector<WorldOption> all = [] {
    std::vector<WorldOption> list(std::begin(kOwn), std::end(kOwn));
    const auto errors = pitch_options();
    list.insert(list.end(), errors.begin(), errors.end());
    list.insert(list.end(), kSharedWorldOptions.begin(), kSharedWorldOptions.end());
    return list;
  }();
  WorldInfo info{"mixed", kKidDevices, all, kMostRobots};
  info.has_bodies = true;
  info.as_robot = mixed_world_of;
  return info;
}

}  // namespace sinew::plant
