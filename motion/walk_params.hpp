#pragma once
// The numbers of a walk.
#include "motion/param.hpp"

namespace sinew::motion {

/// Each with its unit, range and meaning in kWalkParams.
struct WalkParams {
  // The gait.
  double period_s = 0.30;
  double height_m = 0.225;
  double stance_m = 0.088;
  double lift_m = 0.020;
  double lean_rad = 0.03;
  double com_forward_m = 0;
  double cop_inside_m = 0.004;
  double omega_radps = 6.2;
  double swing_begin = 0.05, swing_end = 0.9, swing_ramp = 0.33;
  double lift_peak = 0.45;
  double settle_s = 0.6;
  double arm_swing = 0.6;
  double toe_in_rad = 0.05;
  double turn_stance_m_per_radps = 0.006;
  // Speeds.
  double most_forward_mps = 0.35, most_back_mps = 0.2, most_side_mps = 0.2, most_turn_radps = 1.5;
  double scale_forward = 1, scale_back = 1, scale_side = 1, scale_turn = 1;
  double accel_mps2 = 0.4, turn_accel_radps2 = 4;
  double most_swing_mps = 0.9;
  // Measured support.
  double contact_share = 0.15;
  double switch_least = 0.75;
  double switch_grace_s = 0.2;
  double time_gain = 0.5;
  double time_least = 0.75, time_most = 1.6;
  // Balance.
  double gyro_pitch_s = 0.04, gyro_roll_s = 0.03;
  double tilt_pitch = 0.1, tilt_roll = 0.05;
  double gyro_smooth_s = 0.01;
  double level_swing = 0.5, level_height = 0.3;
  double tip_height = 0;
  double com_per_s = 1, dcm_per_s = 8;
  double dcm_more_per_sm = 0;
  double dcm_dead_m = 0.004;
  double observer_share = 0.25, observer_per_s = 8;
  double cop_most_x_m = 0.035, cop_most_y_m = 0.02;
  double adjust_x = 1, adjust_y = 1;
  double most_step_x_m = 0.14, most_step_y_m = 0.24, least_feet_m = 0.080;
  double bias_s = 3;
  double heading_per_s = 1.5;
  // The servos.
  double late_s = 0.075;
  double lead_s = 0.045;
  double imu_late_s = 0.010;
  double weight_ahead = 1;
  double servo_gain_per_rad = 4.6;
  double play_rad = 0.004;
};

inline constexpr Param<WalkParams> kWalkParams[] = {
    {"period_s", &WalkParams::period_s, "s", 0.18, 0.6, "of one step"},
    {"height_m", &WalkParams::height_m, "m", 0.1, 0.5, "of the hips over the soles"},
    {"stance_m", &WalkParams::stance_m, "m", 0.04, 0.3, "between the middles of the soles, sideways"},
    {"lift_m", &WalkParams::lift_m, "m", 0, 0.08, "of the swinging foot"},
    {"lean_rad", &WalkParams::lean_rad, "rad", -0.3, 0.5, "of the torso, forward"},
    {"com_forward_m", &WalkParams::com_forward_m, "m", -0.05, 0.05, "the centre of mass before the soles' middles"},
    {"cop_inside_m", &WalkParams::cop_inside_m, "m", -0.02, 0.04,
     "how far inside of the sole's middle the ground is planned to push; more: less sway"},
    {"omega_radps", &WalkParams::omega_radps, "rad/s", 3, 10, "of the pendulum: root of g over its height"},
    {"swing_begin", &WalkParams::swing_begin, "1", 0, 0.5, "part of the step after which the foot moves forward"},
    {"swing_end", &WalkParams::swing_end, "1", 0.5, 1, "part of the step after which it has arrived"},
    {"swing_ramp", &WalkParams::swing_ramp, "1", 0.05, 0.5,
     "part of the way's time in which it gets its speed, and loses it; shorter: a lower speed between"},
    {"lift_peak", &WalkParams::lift_peak, "1", 0.2, 0.8, "part of the step at which the foot is highest"},
    {"settle_s", &WalkParams::settle_s, "s", 0.2, 2, "from the last step to standing"},
    {"arm_swing", &WalkParams::arm_swing, "1", 0, 3, "angle of an arm for each angle of the other leg"},
    {"toe_in_rad", &WalkParams::toe_in_rad, "rad", 0, 0.4, "how far toes may point to each other in a turn"},
    {"turn_stance_m_per_radps", &WalkParams::turn_stance_m_per_radps, "m s/rad", 0, 0.05, "wider stance in a turn"},
    {"most_forward_mps", &WalkParams::most_forward_mps, "m/s", 0, 1, "largest command forward"},
    {"most_back_mps", &WalkParams::most_back_mps, "m/s", 0, 1, "largest command backward"},
    {"most_side_mps", &WalkParams::most_side_mps, "m/s", 0, 1, "largest command sideways"},
    {"most_turn_radps", &WalkParams::most_turn_radps, "rad/s", 0, 4, "largest command of turning"},
    {"scale_forward", &WalkParams::scale_forward, "1", 0.5, 2,
     "steps are planned longer by this: feet slip and servos lag"},
    {"scale_back", &WalkParams::scale_back, "1", 0.5, 2, "the same backward"},
    {"scale_side", &WalkParams::scale_side, "1", 0.5, 2, "the same sideways"},
    {"scale_turn", &WalkParams::scale_turn, "1", 0.5, 2, "the same for turning"},
    {"accel_mps2", &WalkParams::accel_mps2, "m/s^2", 0.05, 5, "how fast the speed changes"},
    {"turn_accel_radps2", &WalkParams::turn_accel_radps2, "rad/s^2", 0.2, 20, "how fast the turning rate changes"},
    {"most_swing_mps", &WalkParams::most_swing_mps, "m/s", 0.2, 3, "of a swinging foot over the ground"},
    {"contact_share", &WalkParams::contact_share, "1", 0.02, 0.6, "of the weight on a foot that has touched down"},
    {"switch_least", &WalkParams::switch_least, "1", 0.3, 1, "part of the step before which no touch ends it"},
    {"switch_grace_s", &WalkParams::switch_grace_s, "s", 0, 0.3,
     "how long after the planned end a touch is waited for"},
    {"time_gain", &WalkParams::time_gain, "1", 0, 1, "how much of the sway's measured time the step takes over"},
    {"time_least", &WalkParams::time_least, "1", 0.4, 1, "shortest step, as a part of its period"},
    {"time_most", &WalkParams::time_most, "1", 1, 3, "longest step, as a part of its period"},
    {"gyro_pitch_s", &WalkParams::gyro_pitch_s, "s", 0, 0.3, "ankle pitch for each rad/s of the torso"},
    {"gyro_roll_s", &WalkParams::gyro_roll_s, "s", 0, 0.3, "ankle roll for each rad/s of the torso"},
    {"tilt_pitch", &WalkParams::tilt_pitch, "1", -0.5, 1, "ankle pitch for each rad of the torso's tilt"},
    {"tilt_roll", &WalkParams::tilt_roll, "1", -0.5, 1, "ankle roll for each rad of the torso's tilt"},
    {"gyro_smooth_s", &WalkParams::gyro_smooth_s, "s", 0, 0.1, "low pass of these rates"},
    {"level_swing", &WalkParams::level_swing, "1", 0, 1.5, "how much the swinging sole is kept level against a tilt"},
    {"level_height", &WalkParams::level_height, "1", 0, 1.5, "how much its height is kept against a tilt"},
    {"tip_height", &WalkParams::tip_height, "1", 0, 2,
     "how much lower the swinging foot is put where the carrying sole tips on an edge, which raises the body"},
    {"com_per_s", &WalkParams::com_per_s, "1/s", 0, 30, "how fast the planned centre of mass follows the measured"},
    {"dcm_per_s", &WalkParams::dcm_per_s, "1/s", 0, 60, "how fast the planned dcm follows the measured"},
    {"dcm_more_per_sm", &WalkParams::dcm_more_per_sm, "1/(s m)", 0, 1000, "so much faster for each metre of its error"},
    {"observer_share", &WalkParams::observer_share, "1", 0.02, 1,
     "of an error of the centre of mass that is taken at once"},
    {"observer_per_s", &WalkParams::observer_per_s, "1/s", 0.1, 50, "and how much of it its speed takes"},
    {"dcm_dead_m", &WalkParams::dcm_dead_m, "m", 0, 0.05, "error of the dcm that nothing is done about"},
    {"cop_most_x_m", &WalkParams::cop_most_x_m, "m", 0, 0.1, "how far from the middle the ground may push, forward"},
    {"cop_most_y_m", &WalkParams::cop_most_y_m, "m", 0, 0.1, "the same sideways"},
    {"adjust_x", &WalkParams::adjust_x, "1", 0, 2, "how much of the rest the foot's place answers, forward"},
    {"adjust_y", &WalkParams::adjust_y, "1", 0, 2, "the same sideways"},
    {"most_step_x_m", &WalkParams::most_step_x_m, "m", 0.02, 0.5, "largest distance of the feet, forward"},
    {"most_step_y_m", &WalkParams::most_step_y_m, "m", 0.05, 0.5, "largest distance of the feet, sideways"},
    {"least_feet_m", &WalkParams::least_feet_m, "m", 0.02, 0.3, "smallest distance of the feet, sideways"},
    {"bias_s", &WalkParams::bias_s, "s", 0.3, 60,
     "in which time a lasting error of the dcm is taken as the body's own"},
    {"heading_per_s", &WalkParams::heading_per_s, "1/s", 0, 10, "turning for each rad of lost heading"},
    {"late_s", &WalkParams::late_s, "s", 0, 0.2, "from a target to its effect as it is measured"},
    {"lead_s", &WalkParams::lead_s, "s", 0, 0.2, "servos get targets of so much later, by their rate"},
    {"imu_late_s", &WalkParams::imu_late_s, "s", 0, 0.05, "age of gyro and accelerometer beside that of the joints"},
    {"weight_ahead", &WalkParams::weight_ahead, "1", 0, 2,
     "how much of the servos' yielding to the weight targets take out"},
    {"servo_gain_per_rad", &WalkParams::servo_gain_per_rad, "1/rad", 0.5, 100,
     "what the servos are set to: share of the stall torque for a radian of error; XM430: P gain / 174"},
    {"play_rad", &WalkParams::play_rad, "rad", 0, 0.03, "width of the gears' play"},
};

}  // namespace sinew::motion
