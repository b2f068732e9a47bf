#include <algorithm>
#include <string_view>

#include "robots/gripper/devices.hpp"
#include "sim_hil/worlds/body_errors.hpp"

namespace sinew::plant {
namespace {

constexpr WorldOption kOwn[] = {
    {"start_x_m", "start-x", "m", -4, 4, -1.5, "", "where the robot starts: along the field"},
    {"start_y_m", "start-y", "m", -2.5, 2.5, 0.0, "", "where the robot starts: across the field"},
    {"start_heading_deg", "start-heading", "deg", -180, 180, 0.0, "", "where it looks: 0 along the field"},
    {"ball_away_m", "ball-away", "m", 0.6, 3.5, std::nullopt, "by the seed, 1.3 to 2.4", "from the robot to the ball"},
    {"ball_toward_deg", "ball-toward", "deg", -180, 180, std::nullopt, "by the seed, up to 120 to either side",
     "the ball's direction from the robot: 0 ahead of it, positive to its left"},
};
constexpr std::string_view kOfPitch[] = {"command_delay_ms", "joint_delay_ms", "mass_spread",           "gain_spread",
                                         "sole_friction",    "roughness_mm",   "ball_deceleration_mps2"};

}  // namespace

std::span<const WorldOption> gripper_options() {
  static const std::vector<WorldOption> all = [] {
    std::vector<WorldOption> list(std::begin(kOwn), std::end(kOwn));
    for (const WorldOption& option : pitch_options()) {
      if (std::ranges::find(kOfPitch, option.key) == std::end(kOfPitch)) continue;
      list.push_back(option);
      list.back().per_robot = false;  // there is one
    }
    return list;
  }();
  return all;
}

}  // namespace sinew::plant
