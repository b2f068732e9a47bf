#pragma once
// One joint as a servo moves it: a motor at a bridge, a gear with play, a link that hangs on it. Fast enough to be run
// some hundred times for a fit.
//
//   ServoModel servo{.delay_s = 0.02, .stall_nm = 4.1};
//   servo.run(record.commands, {.first_rad = 0.1}, times, position_rad, effort_nm);
#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "math/elementary.hpp"

namespace sinew::identify {

/// Setpoints as they went out; each holds until the next one. NaN: no torque.
struct CommandLine {
  std::vector<double> time_s;  // rises
  std::vector<double> target_rad;
};

/// Numbers of one joint. The motor gives stall * share - stall / no_load * speed, where its drive takes the share
/// gain * (target - encoder) of the voltage, at most 1; a current limit may cut it. Gravity's torque on the joint is
/// gravity_cos * cos(q) + gravity_sin * sin(q).
/// Source:  the motor: a DC motor at constant voltage, any textbook. Friction: v / (|v| + slow) of the Coulomb torque,
///          plus viscous. Play: M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, a survey (2002),
///          the rigid variant: the rotor moves freely between the flanks and meets them without bouncing.
struct ServoModel {
  double delay_s = 0.01;         // from a command to the motor
  double gain_per_rad = 5;       // share of the voltage for a radian of error
  double stall_nm = 2;           // at full voltage
  double no_load_radps = 5;      // likewise
  double limit_nm = math::kInf;  // of the motor's torque, by its current
  double inertia_kgm2 = 0.01;    // of the link and the rotor, about the joint
  double rotor_kgm2 = 0.003;     // of this the rotor's, seen at the joint
  double coulomb_nm = 0.05;      // of motor, gear and joint; a tenth of it the joint's own
  double slow_radps = 0.05;      // speed at which half of it is there
  double viscous_nms = 0.01;     // of the link's side
  double gravity_cos_nm = 0, gravity_sin_nm = 0;
  double play_rad = 0;            // of the gear, to each side of its middle
  double effort_offset_nm = 0;    // what the effort reads at no torque
  bool encoder_at_motor = false;  // else at the joint

  /// How exactly it is run.
  struct Run {
    double first_rad = 0;  // where the joint rests at first
    double step_s = 5e-4;  // at most
  };
  /// Positions that the encoder has and torques of the motor at these times, which rise; without steps and noise of the
  /// sensors. Runs from the first command or the first time, whichever is earlier.
  /// Shape:   both outputs are as long as `time_s`.   Thread:  any.   RT: yes.
  void run(const CommandLine& commands, const Run& how, std::span<const double> time_s, std::span<double> position_rad,
           std::span<double> effort_nm) const;
};

/// The model's numbers in an order, for fits and reports.
enum class ServoParameter : std::uint8_t {
  delay,
  gain,
  stall,
  no_load,
  limit,
  inertia,
  rotor,
  coulomb,
  slow,
  viscous,
  gravity_cos,
  gravity_sin,
  play,
  effort_offset,
};
inline constexpr std::size_t kServoParameters = 14;

struct ServoParameterText {
  std::string_view name, unit, doc;
  double ServoModel::*value;
};
/// By ServoParameter.
const std::array<ServoParameterText, kServoParameters>& servo_parameters();

}  // namespace sinew::identify
