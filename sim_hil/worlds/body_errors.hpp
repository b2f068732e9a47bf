#pragma once
// What a real body does worse than its drawing: one flat table of numbers, which are options of the robot file.
#include <cstdint>
#include <span>

#include "math/elementary.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// Errors of one robot, all on by default. kNan: drawn by the seed, or as the body's file says.
/// Source of each figure: docs/pitch.md.
struct BodyErrors {
  double command_delay_ms = math::kNan;  // from command() to the servo; by the seed 20 to 36
  double joint_delay_ms = 6;             // from the encoder to sensors(): the bus is read in turn
  double imu_delay_ms = 10;
  double stall_nm = math::kNan;       // of every servo; as the body's file
  double no_load_radps = math::kNan;  // likewise
  double backlash_deg = 0.25;         // of the gear to each side of its middle
  double encoder_at_motor = 0;        // 1: the encoder is on the motor's side of the gear's play
  double encoder_steps = 4096;        // a turn; 0: exact
  double gear_friction_share = 0.02;  // Coulomb friction, of the stall torque
  double mass_spread = 0.05;          // each link's mass: uniformly up to this share off
  double gain_spread = 0.05;          // each servo's gain likewise
  double sole_friction = math::kNan;  // by the seed 0.6 to 1.0
  double gyro_noise_radps = 0.004;    // sigma
  double gyro_bias_radps = 0.01;      // sigma, drawn once for each axis
  double accel_noise_mps2 = 0.06;
  double accel_bias_mps2 = 0.08;
  double cell_noise_n = 0.3;  // of a pressure cell, sigma
  double cell_spread = 0.1;   // its scale: uniformly up to this share off
  double ambient_c = 25;      // of the air around the servos
  double joint_zero_deg = 0;  // of an encoder where the joint is at 0: sigma, drawn once; targets are off by as much
  double sole_tilt_deg = 0;   // of each sole about its two axes: sigma, drawn once
  double sole_height_mm = 0;  // of each sole, thicker or thinner: sigma, drawn once

  /// A body as in its drawing: no delay, play, noise or spread; friction 0.8, air at 25 degrees.
  static BodyErrors none();
  /// Of the options in `values`; others have their defaults.
  static BodyErrors from(const WorldValues& values);
};

/// Errors of the ground, for all robots on it.
struct GroundErrors {
  double roughness_mm = 3;  // heights are uniform between plus and minus this, in cells of 40 mm; 0: a plane

  double ball_deceleration_mps2 = 0.35;  // of a rolling ball, by the grass

  /// A plane; the grass is as it is.
  static GroundErrors none();
  static GroundErrors from(const WorldValues& values);
};

/// A line for each of these numbers: key, unit, range, default. Lives as long as the program.
std::span<const WorldOption> pitch_options();

}  // namespace sinew::plant
