#pragma once
// A wheeled robot with a gripper, of the class of ActivMedia's Pioneer 2-DX: two driven wheels, a caster behind them,
// two paddles in front that close on a ball.
//
//   PitchBody robot = pioneer_body({.x_m = -2});
//   ...
//   drive_wheels(*pitch, 0, {.forward_mps = 0.4, .turn_radps = 0.5});
//   grip(*pitch, 0, 0.10);
//
// Frames:  link 0 is the base: x forward, z up, its origin between the wheels, on the ground where they stand on it.
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// Source:  sizes and places of body, wheels and caster: the Stage simulator's worlds/pioneer.inc, whose outer size of
///          44 x 38 x 22 cm is the maker's. Mass, speed and encoder steps are those commonly given for the robot. The
///          gripper's force is the largest grasping pressure in the maker's PeopleBot manual, about 2 kg; whether that
///          is of one paddle it does not say. The gripper's size and speed, inertias and the motors' torque are ours.
struct WheeledSize {
  double length_m = 0.44, width_m = 0.28, low_m = 0.059, high_m = 0.234;  // of the body between the wheels
  double middle_x_m = -0.04;                                              // of the body; the wheels turn about 0
  double wheel_radius_m = 0.0825, wheel_width_m = 0.037, track_m = 0.317;
  double caster_x_m = -0.215, caster_radius_m = 0.0325;
  double mass_kg = 9, wheel_kg = 0.4, paddle_kg = 0.15;
  double fastest_mps = 1.6, wheel_stall_nm = 6;
  double encoder_steps = 9850;  // of a wheel's turn
  double paddle_long_m = 0.12, paddle_high_m = 0.06, paddle_thick_m = 0.012, paddle_low_m = 0.03;
  double opening_m = 0.215;            // between the open paddles
  double grip_n = 20, grip_mps = 0.1;  // of each paddle
};
inline constexpr WheeledSize kPioneer{};

/// Joints in this order: wheels in rad, paddles in m from where they are open, inwards.
enum WheeledJoint : std::size_t { kLeftWheel, kRightWheel, kLeftPaddle, kRightPaddle, kWheeledJoints };

PitchBody pioneer_body(const PitchPlace& start = {});

struct WheelCommand {
  double forward_mps = 0, turn_radps = 0;
};
/// Speeds of the wheels that move the base like this, each within what the motors can.
void drive_wheels(Pitch& pitch, std::size_t robot, const WheelCommand& command);
/// Moves both paddles until so much is between them, 0 to opening_m, or until they hold something.
void grip(Pitch& pitch, std::size_t robot, double between_m);
/// What its encoders say is between the paddles.
double between_paddles_m(const BodySensors& sensors);

/// Its part of the model's XML.
std::string wheeled_xml(const kinematics::Body& body, const std::string& name_end, double friction);

}  // namespace sinew::plant
