#pragma once
// Walks of many kinds on the pitch, and what came of them.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

enum class Course : std::uint8_t { forward, back, side, turn, mixed, stop_and_go };
inline constexpr std::array kCourses{Course::forward, Course::back,  Course::side,
                                     Course::turn,    Course::mixed, Course::stop_and_go};
std::string to_string(Course course);

struct Push {
  double speed_mps = 0;      // change of the whole body's speed
  double direction_rad = 0;  // in which it goes, from the torso's x to its left
  double lasts_s = 0.1;
};

struct WalkTrial {
  Course course = Course::forward;
  std::uint64_t seed = 1;
  double lasts_s = 60;
  double speed_share = 1;               // of the largest speeds that the motion file allows
  std::optional<double> forward_mps{};  // instead
  Push push{};                          // each push_every_s, at a random phase
  double push_every_s = 0;              // 0: none
  bool looks = false;                   // at something that goes to and fro before it; otherwise its head rests
};

struct WalkResult {
  bool fell = false;
  double time_s = 0;                                     // that it walked, until its end or its fall
  double forward_mps = 0, left_mps = 0, turn_radps = 0;  // true means while it walked with steady commands
  double wanted_forward_mps = 0, wanted_left_mps = 0, wanted_turn_radps = 0;  // means of the commands then
  double odometry_m = 0, path_m = 0;               // error of the odometry at the end, and how far the torso went
  double step_error_m = 0;                         // mean error of the odometry over a second, and
  double step_m = 0;                               // mean way in a second
  double tilt_rad = 0;                             // largest sum of tilt and rate / omega
  double off_axis_rad = 0, most_off_axis_rad = 0;  // of the camera from where it is to look: mean, largest
  bool false_alarm = false;                        // a fall was told that was none: 1 s later it still walked
  std::uint64_t steps = 0;
};

/// Stands for 1.5 s, then walks.
/// Errors:  nothing, with `why`.
std::optional<WalkResult> run_walk(const GaitSetup& setup, const WalkTrial& trial, std::string& why);

}  // namespace sinew::gait
