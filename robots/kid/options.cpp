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
    {"start_lie", "start-lie", "", 0, 4, 0.0, "",
     "0: it stands; it lies 1: on its front, 2: on its back, 3: on its left side, 4: on its right side", true, true},
    {"servo_gain_per_rad", "servo-gain", "1/rad", 0.5, 100, 4.6, "",
     "what its servos are set to: share of the voltage for a radian of error; XM430: P gain / 174", false, true},
    {"ball_x_m", "ball-x", "m", -5, 5, 0.0, "", "where the ball is: along the field"},
    {"ball_y_m", "ball-y", "m", -4, 4, 0.0, "", "where the ball is: across the field"},
    {"push_ns", "torso-push", "N s", 0, 20, 0.0, "", "an impulse on the torso over 0.1 s, every 10 s from the third on",
     false, true},
    {"push_from_deg", "torso-push-from", "deg", -180, 180, 0.0, "",
     "from where it comes: 0 from behind, 90 from the right, 180 from the front", false, true},
    {"team", "team", "", 0, 1, 0.0, "", "its colour and side: 0 blue, defends -x in the first half; 1 red", true, true},
    {"ball_roll_mps", "ball-roll", "m/s", 0, 10, 0.0, "", "the ball is set rolling once with this speed"},
    {"ball_roll_deg", "ball-roll-toward", "deg", -180, 180, 0.0, "", "where to: 0 along the field"},
    {"ball_roll_at_s", "ball-roll-at", "s", 0, 3600, 0.0, "", "and when"},
    {"board_square_mm", "board-square", "mm", 0, 200, 0.0, "",
     "a printed chessboard of 10 x 7 squares is on the field, with squares of this size; 0: none"},
    {"board_x_m", "board-x", "m", -5, 5, 0.0, "", "where the middle of its nearer edge is: along the field"},
    {"board_y_m", "board-y", "m", -4, 4, 0.0, "", "and across the field"},
    {"board_heading_deg", "board-heading", "deg", -180, 180, 0.0, "", "where somebody looks who stands before it"},
    {"board_lean_deg", "board-lean", "deg", 0, 90, 0.0, "", "its farther edge is raised: 0 it lies, 90 it stands"},
    {"camera_focal", "camera-focal", "", 0.3, 3, 0.875, "",
     "focal length of the robots' cameras, as a share of the picture's height"},
    {"camera_k1", "camera-k1", "", -0.5, 0.5, 0.0, "", "radial distortion of their lenses, by the radius squared"},
    {"camera_k2", "camera-k2", "", -0.5, 0.5, 0.0, "", "and by its fourth power"},
    {"kinematic", "kinematic", "", 0, 1, 0.0, "",
     "1: without dynamics: the lowest foot is fixed to flat ground and the body moves over it; nobody falls or is "
     "pushed",
     true},
    {"referee", "referee", "", 0, 1, 0.0, "", "1: a referee leads a game of two halves, from the start on", true},
    {"referee_ready_s", "referee-ready", "s", 0, 600, 45.0, "", "to go to one's place"},
    {"referee_set_s", "referee-set", "s", 0, 600, 5.0, "", "to stand there before the kick-off"},
    {"referee_half_s", "referee-half", "s", 1, 3600, 600.0, "", "a half lasts"},
    {"referee_fallen_s", "referee-fallen", "s", 1, 600, 20.0, "", "a robot that lies for longer is penalised"},
    {"referee_penalty_s", "referee-penalty", "s", 0, 600, 30.0, "", "a penalty lasts"},
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
