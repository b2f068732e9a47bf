#include "sim_hil/worlds/body_errors.hpp"

#include <array>
#include <tuple>
#include <type_traits>

namespace sinew::plant {
namespace {

/// An option, and the number that it sets in one of the two structs.
struct Line {
  WorldOption option;
  double BodyErrors::*of_body = nullptr;
  double GroundErrors::*of_ground = nullptr;
};

WorldOption option(const char* key, const char* name, const char* unit, double least, double most, double value,
                   const char* otherwise, const char* doc, bool whole = false) {
  WorldOption o;
  o.key = key, o.option = name, o.unit = unit;
  o.least = least, o.most = most;
  if (math::is_finite(value)) o.value = value;
  o.otherwise = otherwise, o.doc = doc, o.whole = whole;
  return o;
}

Line of_body(const char* key, const char* name, const char* unit, double least, double most, double BodyErrors::*member,
             const char* doc, const char* otherwise = "", bool whole = false) {
  Line line{option(key, name, unit, least, most, BodyErrors{}.*member, otherwise, doc, whole), member};
  line.option.per_robot = true;
  return line;
}

const auto& lines() {
  static const std::array all{
      of_body("command_delay_ms", "command-delay", "ms", 0, 60, &BodyErrors::command_delay_ms,
              "time from a command to the servo that obeys it", "by the seed, from 20 to 36"),
      of_body("joint_delay_ms", "joint-delay", "ms", 0, 40, &BodyErrors::joint_delay_ms,
              "age of encoder values and of pressures when the robot gets them"),
      of_body("imu_delay_ms", "imu-delay", "ms", 0, 40, &BodyErrors::imu_delay_ms,
              "age of gyro and accelerometer values when the robot gets them"),
      of_body("stall_nm", "stall", "N m", 0.1, 50, &BodyErrors::stall_nm, "stall torque of every servo",
              "as the body's file says"),
      of_body("no_load_radps", "no-load", "rad/s", 0.5, 50, &BodyErrors::no_load_radps,
              "speed without load of every servo", "as the body's file says"),
      of_body("backlash_deg", "backlash", "degrees", 0, 2, &BodyErrors::backlash_deg,
              "play of each gear, to each side of its middle"),
      of_body("encoder_at_motor", "encoder-at-motor", "", 0, 1, &BodyErrors::encoder_at_motor,
              "1: encoders sit on the motor's side of the play, 0: at the joint", "", true),
      of_body("encoder_steps", "encoder-steps", "steps a turn", 0, 1048576, &BodyErrors::encoder_steps,
              "resolution of the encoders; 0: exact", "", true),
      of_body("gear_friction_share", "gear-friction", "", 0, 0.3, &BodyErrors::gear_friction_share,
              "Coulomb friction of each gear as a share of its stall torque"),
      of_body("mass_spread", "mass-spread", "", 0, 0.3, &BodyErrors::mass_spread,
              "each link's mass is up to this share off the body's file"),
      of_body("gain_spread", "gain-spread", "", 0, 0.3, &BodyErrors::gain_spread,
              "each servo's gain is up to this share off"),
      of_body("sole_friction", "sole-friction", "", 0.1, 2, &BodyErrors::sole_friction,
              "friction of the robot on the ground", "by the seed, from 0.6 to 1.0"),
      of_body("gyro_noise_radps", "gyro-noise", "rad/s", 0, 1, &BodyErrors::gyro_noise_radps,
              "noise of each gyro axis, sigma of a sample"),
      of_body("gyro_bias_radps", "gyro-offset", "rad/s", 0, 1, &BodyErrors::gyro_bias_radps,
              "offset of each gyro axis, sigma, drawn once"),
      of_body("accel_noise_mps2", "accel-noise", "m/s2", 0, 10, &BodyErrors::accel_noise_mps2,
              "noise of each accelerometer axis, sigma of a sample"),
      of_body("accel_bias_mps2", "accel-offset", "m/s2", 0, 10, &BodyErrors::accel_bias_mps2,
              "offset of each accelerometer axis, sigma, drawn once"),
      of_body("cell_noise_n", "cell-noise", "N", 0, 10, &BodyErrors::cell_noise_n,
              "noise of each pressure cell, sigma of a sample"),
      of_body("cell_spread", "cell-spread", "", 0, 0.5, &BodyErrors::cell_spread,
              "each pressure cell's scale is up to this share off"),
      of_body("ambient_c", "ambient", "degrees C", -40, 85, &BodyErrors::ambient_c,
              "temperature of the air around the servos, which they begin with"),
      of_body(
          "joint_zero_deg", "joint-zero", "degrees", 0, 10, &BodyErrors::joint_zero_deg,
          "error of each joint's zero, of encoder and target, sigma, drawn once: what `sinew calibrate legs` finds"),
      of_body("sole_tilt_deg", "sole-tilt", "degrees", 0, 5, &BodyErrors::sole_tilt_deg,
              "tilt of each sole about its two axes, sigma, drawn once"),
      of_body("sole_height_mm", "sole-height", "mm", 0, 10, &BodyErrors::sole_height_mm,
              "each sole is thicker or thinner, sigma, drawn once"),
      Line{option("roughness_mm", "roughness", "mm", 0, 10, GroundErrors{}.roughness_mm, "",
                  "the ground under feet is up to this above or below a plane, in cells of 40 mm"),
           nullptr, &GroundErrors::roughness_mm},
      Line{option("ball_deceleration_mps2", "ball-deceleration", "m/s2", 0, 5, GroundErrors{}.ball_deceleration_mps2,
                  "", "what the grass takes from a rolling ball's speed in a second"),
           nullptr, &GroundErrors::ball_deceleration_mps2},
  };
  return all;
}

}  // namespace

std::span<const WorldOption> pitch_options() {
  static const auto all = [] {
    std::array<WorldOption, std::tuple_size_v<std::remove_cvref_t<decltype(lines())>>> options;
    for (std::size_t i = 0; i < options.size(); ++i) options[i] = lines()[i].option;
    return options;
  }();
  return all;
}

BodyErrors BodyErrors::none() {
  BodyErrors e;
  for (const Line& line : lines())
    if (line.of_body) e.*line.of_body = 0;
  e.stall_nm = e.no_load_radps = math::kNan;
  e.sole_friction = 0.8;
  e.ambient_c = 25;
  return e;
}

BodyErrors BodyErrors::from(const WorldValues& values) {
  BodyErrors e;
  for (const Line& line : lines())
    if (const auto it = values.find(line.option.key); line.of_body && it != values.end()) e.*line.of_body = it->second;
  return e;
}

GroundErrors GroundErrors::none() {
  GroundErrors e;
  e.roughness_mm = 0;
  return e;
}

GroundErrors GroundErrors::from(const WorldValues& values) {
  GroundErrors e;
  for (const Line& line : lines())
    if (const auto it = values.find(line.option.key); line.of_ground && it != values.end())
      e.*line.of_ground = it->second;
  return e;
}

}  // namespace sinew::plant
