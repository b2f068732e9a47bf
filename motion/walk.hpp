#pragma once
// Walking: from a wanted speed and what the body measures to a target for each joint.
#include "motion/figure.hpp"
#include "motion/kick_way.hpp"
#include "motion/pendulum.hpp"
#include "motion/planar.hpp"
#include "motion/servo_lead.hpp"
#include "motion/stance.hpp"
#include "motion/step_kick.hpp"
#include "motion/tilt.hpp"
#include "motion/walk_params.hpp"

namespace sinew::motion {

/// Wanted speed of the torso, in its own axes.
struct WalkCommand {
  double forward_mps = 0, left_mps = 0, turn_radps = 0;
  bool walk = false;  // false: stop and stand; true with zero speeds: march in place

  template <class Visit>
  void each_part(Visit&& visit) {
    visit(forward_mps, left_mps, turn_radps, walk);
  }
};

enum class WalkPhase : std::uint8_t {
  stand,
  shift,  // the weight is thrown to one foot, before the first step
  step,
};

/// Omnidirectional walk.
///
/// The plan is a pendulum over the supporting sole. Each step has a place for the other foot, and a dcm to be reached
/// when it lands, with which the next step begins as in a steady walk; the ground's push is placed so that the plan
/// gets there. The plan is drawn to the measured pendulum: centre of mass from joints and attitude, its speed from an
/// observer that knows where the soles are pressed; a target's way to the servos, through them and back is known, so
/// that the measured state is compared with the plan of then. An error that the push under the sole cannot make
/// good moves the place where the foot will land (step adjustment), and the sway's measured time moves the end of the
/// step. The step ends when the other foot carries weight, within limits. Gyro and tilt turn the ankles.
/// Frames:  support: middle of the supporting sole, x to its toes, z up.
/// Thread:  owner.   RT: yes, after the constructor.
/// Source:  pendulum.hpp; steps that answer errors: M. Missura, S. Behnke, Omnidirectional capture steps for bipedal
///          walking (Humanoids 2013); steps ended by pressure, gyro at the ankles: B. Hengst, rUNSWift Walk2014.
class Walk {
 public:
  WalkParams params;
  StepKickParams kick_forward, kick_outward;
  Tilt tilt;

  /// `rest_rad`: angles of the joints that the walk does not move; of shoulders, about which they swing.
  Walk(const Figure& figure, std::span<const double> rest_rad);

  /// Stands from now on, with the soles where they are measured; the plan begins anew.
  void reset(const Sensed& sensed);
  /// Targets for all joints. `dt_s`: since the last step.
  void step(const WalkCommand& command, const Sensed& sensed, double dt_s, std::span<double> targets_rad);

  /// Attitude, stance and odometry go on while another motion has the joints.
  void sense_only(const Sensed& sensed, double dt_s);
  /// Takes the joints over from a motion that ended in the standing pose: as reset(), but attitude, the gyro's bias and
  /// odometry go on.
  void take_over(const Sensed& sensed);

  /// A step of this foot is a kick: the next one that comes after a whole step of the other foot, which throws the
  /// weight as far over as the kick's longer step needs. Forgotten when the walk stands.
  void kick(Side foot, KickWay way);
  void forget_kick() { wants_kick_ = prepares_ = false; }  // one that has begun goes on
  bool kicks() const { return kicking_ || wants_kick_; }
  bool kicking() const { return kicking_; }  // in this step

  WalkPhase phase() const { return phase_; }
  Side support() const { return support_; }
  std::uint64_t steps() const { return steps_; }
  /// The torso in the odometry's frame, which begins at reset(): x forward then.
  const Planar& odometry() const { return odometry_; }
  const Stance& stance() const { return sense_.stance(); }
  /// Attitude now, IMU's delay taken out.
  const math::Quat& q_world_torso() const { return q_now_; }
  /// Error of the dcm against the plan, support frame: what pushes do.
  const Vec2& dcm_error_m() const { return error_m_; }
  /// The speed that the present step has, after limits.
  const WalkCommand& speed() const { return speed_; }
  const Planar& landing() const { return landing_; }
  /// State (kept_numbers.hpp): all that a step leaves for later ones.
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(com_in_torso_, torso_over_hips_m_, tilt, lead_, phase_, support_, command_, speed_, next_speed_, time_s_,
          end_s_, steps_, stopping_, plan_, cop_m_, foot_, lifted_, landing_, foot_z_m_, lifted_z_m_, support_z_m_,
          support_z0_m_, yaw0_rad_, swung_, carried_, frame_yaw_rad_, heading_rad_, past_, newest_, dt_s_, q_now_,
          rate_, seen_, seen_support_, seeing_, error_m_, bias_m_, anchor_, odometry_, touch_s_, wants_kick_, prepares_,
          kicking_, kick_foot_, kick_way_);
  }

 private:
  struct Axes {
    Pendulum x, y;

    template <class Visit>
    void each_part(Visit&& visit) {
      visit(x, y);
    }
  };
  struct Past {  // of the plan
    Axes plan;
    double yaw_rad = 0;  // of the support frame
    Side support = Side::left;
    std::uint32_t valid = 0;

    template <class Visit>
    void each_part(Visit&& visit) {
      visit(plan, yaw_rad, support, valid);
    }
  };
  struct Goal {
    Planar foot;  // of the other foot, in the support frame
    Vec2 dcm_m;   // at the step's end
  };
  static constexpr std::size_t kPast = 32;

  void begin_plan(const Sensed& sensed);
  void sense(const Sensed& sensed, double dt_s);
  void observe(double dt_s);
  void correct(double dt_s);
  void stand(double dt_s);
  void shift(double dt_s);
  void advance_step(double dt_s);
  void begin_step();
  void end_step();
  void choose_speed(const WalkCommand& command);
  Goal goal() const;
  Vec2 push_under_sole(const Goal& goal, double left_s);
  void move_foot(const Planar& to, double dt_s);
  void change_support(const Planar& new_support);
  void remember();
  const Past& past(double age_s) const;
  void write(double dt_s, std::span<double> targets_rad);
  double torso_yaw() const;
  double wanted_distance() const;
  double period() const { return kicking_ ? kick_params().stretch * params.period_s : params.period_s; }
  const StepKickParams& kick_params() const { return kick_way_ == KickWay::forward ? kick_forward : kick_outward; }
  struct KickOffset {
    math::Vec3 at_m;
    math::Quat turn, lean;  // of the sole; of the torso about the centre of mass
  };
  KickOffset kick_offset() const;

  const Figure* figure_;
  StanceSense sense_;
  ServoLead lead_;
  JointAngles rest_rad_{};
  math::Vec3 com_in_torso_;  // of the standing body, from the torso's origin, axes of the ground
  double torso_over_hips_m_ = 0;

  WalkPhase phase_ = WalkPhase::stand;
  Side support_ = Side::right;
  WalkCommand command_, speed_, next_speed_;
  double time_s_ = 0, end_s_ = 0.3;  // of the step
  std::uint64_t steps_ = 0, stopping_ = 0;
  Axes plan_;
  Vec2 cop_m_;
  Planar foot_, lifted_, landing_;  // the other foot: now, where it was lifted, where it will land
  double foot_z_m_ = 0, lifted_z_m_ = 0, support_z_m_ = 0, support_z0_m_ = 0;
  double yaw0_rad_ = 0;  // of the torso at the step's begin
  double swung_ = 0;     // part of the foot's way
  std::array<double, 2> carried_{0.5, 0.5};
  double frame_yaw_rad_ = 0, heading_rad_ = 0;  // of the plan: support frame; wanted heading

  std::array<Past, kPast> past_{};
  std::size_t newest_ = 0;
  double dt_s_ = 0.01;

  math::Quat q_now_;
  math::Vec3 rate_;
  Axes seen_;  // relative to the sole that carried `late_s` ago
  Side seen_support_ = Side::right;
  bool seeing_ = false;
  Vec2 error_m_;
  std::array<Vec2, 2> bias_m_{};
  Planar anchor_, odometry_;
  double touch_s_ = 0;
  bool wants_kick_ = false, prepares_ = false, kicking_ = false;
  Side kick_foot_ = Side::left;
  KickWay kick_way_ = KickWay::forward;
};

}  // namespace sinew::motion
