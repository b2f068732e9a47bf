#pragma once
// Where a robot's head is to look, and where it looks.
#include "msg/geometry.hpp"

namespace sinew::msg {

enum class GazeAim : std::uint32_t {
  rest = 0,       // the head is where the body's motions want it
  ahead = 1,      // straight ahead of the body, at the horizon
  direction = 2,  // along `to`
  point = 3       // at `to`
};

inline constexpr ValueName kGazeAimNames[] = {
    {"rest", GazeAim::rest}, {"ahead", GazeAim::ahead}, {"direction", GazeAim::direction}, {"point", GazeAim::point}};

enum class GazeFrame : std::uint32_t {
  odometry = 0,  // of GaitState: z up, 0 on the ground
  robot = 1      // on the ground below the torso, x to where it is turned, z up
};

inline constexpr ValueName kGazeFrameNames[] = {{"odometry", GazeFrame::odometry}, {"robot", GazeFrame::robot}};

/// Where a head is to look. It holds until the next one.
struct GazeCommand {
  Time stamp;
  Vec3 to;  // a direction of any length, or a point in m
  GazeAim aim = GazeAim::rest;
  GazeFrame frame = GazeFrame::odometry;
};

/// Where a head looks, as far as the robot knows.
struct GazeState {
  Time stamp;            // of the joints that it rests on
  double pan_rad = 0;    // target of the joint
  double tilt_rad = 0;   // target of the joint
  double error_rad = 0;  // of the camera's axis from where it is to look
  GazeAim aim = GazeAim::rest;
  std::uint32_t limited = 0;  // 1: the neck does not reach that far
};

template <>
struct Description<GazeCommand> {
  using M = GazeCommand;
  static constexpr std::string_view name = "GazeCommand", doc = "Where a head is to look. It holds until the next one.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::to>("m", "a direction of any length, or a point in m"),
               enum_field<&M::aim>(kGazeAimNames), enum_field<&M::frame>(kGazeFrameNames));
};

template <>
struct Description<GazeState> {
  using M = GazeState;
  static constexpr std::string_view name = "GazeState", doc = "Where a head looks, as far as the robot knows.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns", "of the joints that it rests on"),
               field<&M::pan_rad>("rad", "target of the joint"), field<&M::tilt_rad>("rad", "target of the joint"),
               field<&M::error_rad>("rad", "of the camera's axis from where it is to look"),
               enum_field<&M::aim>(kGazeAimNames), field<&M::limited>("1", "1: the neck does not reach that far"));
};

}  // namespace sinew::msg
