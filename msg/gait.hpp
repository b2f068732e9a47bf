#pragma once
// How a robot with legs moves.
#include "msg/kick.hpp"

namespace sinew::msg {

enum class GaitMode : std::uint32_t {
  limp = 0,   // not permitted to move, or waiting for its first measurements: commands nothing
  stand = 1,  // or on its way to stand
  walk = 2,
  fall = 3,  // a fall was seen that cannot be helped: joints give way
  lie = 4,   // at rest on the ground
  rise = 5,
  down = 6,  // getting down by itself, and then at rest there without torque
  kick = 7,  // the foot is on its way to the ball, or back
  stop = 8,  // it stops a ball
};

/// It carries itself on its soles.
constexpr bool on_its_feet(GaitMode mode) {
  return mode == GaitMode::stand || mode == GaitMode::walk || mode == GaitMode::kick || mode == GaitMode::stop;
}

inline constexpr ValueName kGaitModeNames[] = {
    {"limp", GaitMode::limp}, {"stand", GaitMode::stand}, {"walk", GaitMode::walk},
    {"fall", GaitMode::fall}, {"lie", GaitMode::lie},     {"rise", GaitMode::rise},
    {"down", GaitMode::down}, {"kick", GaitMode::kick},   {"stop", GaitMode::stop}};

/// What a walking body does, and where it believes it has come.
struct GaitState {
  Time stamp;  // of the joints that it rests on
  Time mode_since;
  Quat q_world_torso;       // z up; x as the torso's when the module began
  Vec3 gyro_radps;          // without bias, torso axes
  double x_m = 0, y_m = 0;  // odometry of the torso, in the frame of its begin
  double height_m = 0;      // of the torso's origin over the ground, by the legs
  double heading_rad = 0;
  double forward_mps = 0, left_mps = 0, turn_radps = 0;  // of the present step
  double error_x_m = 0, error_y_m = 0;  // of the divergent component of motion against the plan: what pushes do
  GaitMode mode = GaitMode::limp;
  std::uint32_t support = 0;  // 0: the left foot, 1: the right foot
  std::uint32_t steps = 0;
  std::uint32_t falls = 0;
  std::uint32_t request = 0;  // id of the KickRequest that was taken last, and how far it is
  RequestProgress progress = RequestProgress::none;
  std::uint32_t refused = 0;  // id of the KickRequest that was refused last, and why
  RequestRefusal refusal = RequestRefusal::none;
};

template <>
struct Description<GaitState> {
  static constexpr std::string_view name = "GaitState", doc = "How a robot with legs moves.";
  static constexpr auto fields =
      describe(field<&GaitState::stamp>("ns", "of the joints that it rests on"), field<&GaitState::mode_since>("ns"),
               field<&GaitState::q_world_torso>("1", "z up; x as the torso's at the begin"),
               field<&GaitState::gyro_radps>("rad/s", "without bias, torso axes"),
               field<&GaitState::x_m>("m", "odometry, in the frame of its begin"), field<&GaitState::y_m>("m"),
               field<&GaitState::height_m>("m", "of the torso over the ground, by the legs"),
               field<&GaitState::heading_rad>("rad"), field<&GaitState::forward_mps>("m/s", "of the present step"),
               field<&GaitState::left_mps>("m/s"), field<&GaitState::turn_radps>("rad/s"),
               field<&GaitState::error_x_m>("m", "of the divergent component of motion against the plan"),
               field<&GaitState::error_y_m>("m"), enum_field<&GaitState::mode>(kGaitModeNames),
               field<&GaitState::support>("1", "0: the left foot, 1: the right one"), field<&GaitState::steps>("1"),
               field<&GaitState::falls>("1"), field<&GaitState::request>("1", "id of the KickRequest taken last"),
               enum_field<&GaitState::progress>(kRequestProgressNames, "of this request"),
               field<&GaitState::refused>("1", "id of the KickRequest refused last"),
               enum_field<&GaitState::refusal>(kRequestRefusalNames, "why it was refused"));
};

}  // namespace sinew::msg
