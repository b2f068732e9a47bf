#include "robots/kid/devices.hpp"
#include "sim_hil/worlds/air.hpp"
#include "sim_hil/worlds/body_errors.hpp"

namespace sinew::plant {
namespace {

constexpr WorldOption kOwn[] = {
    {"start_x_m", "start-x", "m", -5, 5, std::nullopt, "by its number: 1 m apart, on its own half",
     "where the robot starts: along the field", false, true},
    {"start_y_m", "start-y", "m", -4, 4, std::nullopt, "by its number", "where the robot starts: across the field",
     false, true},
    {"start_heading_deg", "start-heading", "deg", -180, 180, 0.0, "", "where it looks: 0 along the field", false, true},
    {"start_lie", "start-lie", "", 0, 2, 0.0, "", "0: it stands; 1: it lies on its front, 2: on its back", true, true},
    {"servo_gain_per_rad", "servo-gain", "1/rad", 0.5, 100, 4.6, "",
     "what its servos are set to: share of the voltage for a radian of error; XM430: P gain / 174", false, true},
    {"ball_x_m", "ball-x", "m", -5, 5, 0.0, "", "where the ball is: along the field"},
    {"ball_y_m", "ball-y", "m", -4, 4, 0.0, "", "where the ball is: across the field"},
    {"ball_mps", "ball-speed", "m/s", 0, 5, 0.0, "", "how fast it rolls from there at `ball_rolls_s`; 0: it lies"},
    {"ball_heading_deg", "ball-heading", "deg", -180, 180, 180.0, "", "where to: 0 along the field"},
    {"ball_rolls_s", "ball-rolls", "s", 0, 600, 5.0, "", "when it begins to roll"},
    {"push_ns", "torso-push", "N s", 0, 20, 0.0, "", "an impulse on the torso over 0.1 s, every 10 s from the third on",
     false, true},
    {"push_from_deg", "torso-push-from", "deg", -180, 180, 0.0, "",
     "from where it comes: 0 from behind, 90 from the right, 180 from the front", false, true},
};

}  // namespace

std::span<const WorldOption> soccer_options() {
  static const std::vector<WorldOption> all = [] {
    std::vector<WorldOption> list(std::begin(kOwn), std::end(kOwn));
    const auto errors = pitch_options();
    list.insert(list.end(), errors.begin(), errors.end());
    list.insert(list.end(), kSharedWorldOptions.begin(), kSharedWorldOptions.end());
    return list;
  }();
  return all;
}

}  // namespace sinew::plant
