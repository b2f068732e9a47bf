#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/safety.hpp"

namespace sinew::control {

/// Numbers of the mission; the module Mission gives each its range.
struct MissionParams {
  double settle_s = 1.5;   // of valid estimate before arming
  double spin_up_s = 0.7;  // motors idle before the climb
  double search_height_m = 2.2, approach_height_m = 1.3;
  double climb_mps = 0.6, speed_mps = 0.5, accel_mps2 = 0.8;
  double search_spacing_m = 1.0, search_radius_m = 2.0;
  double arrived_m = 0.12, arrived_mps = 0.20;
  double look_s = 2.0, hold_s = 3.0;                 // hovering before the search and before the landing
  double sink_fast_mps = 0.3, sink_slow_mps = 0.18;  // above and below
  double slow_below_m = 0.5;
  double centred_m = 0.10, centred_per_m = 0.15;  // how far off the sinking goes on: centred + per_m * height
  double commit_below_m = 0.45;                   // lower than this it lands without further sightings
  double pad_lost_s = 1.5;
  double feet_below_base_m = 0.12;
  double touch_margin_m = 0.04, touch_mps = 0.12, touch_s = 0.25;
  double stuck_mps = 0.06, stuck_s = 1.5;  // sinking is wanted, but it does not sink: on the ground
  double felt_s = 0.75;                    // that much in the descent, and it lands without further sightings
  double stuck_high_s = 6;                 // the same where the range finder says otherwise: it may only sink late
  double slow_unseen_m = 0.5;              // sinks slowly from so much higher where no range finder measures the height
  double timeout_s = 90, blind_s = 8, estimate_lost_s = 0.3;
  // Every phase has a limit. A climb takes 4 s, a descent from the highest 12 s; settling takes 3 s, but another module
  // may fly figures above the pad meanwhile.
  double climb_limit_s = 12, hold_limit_s = 30, abort_limit_s = 40;
  double land_x_m = 0, land_y_m = 0;  // where it lands, from the pad's centre
  double told_std_m = 0.5;            // a told pad that is less sure is not believed
  double ahead_silent_s = 3;          // a mate that is to land first and is not heard for so long is waited for no more
  double fall_mps = 1.5;              // its own sinking is less than half as fast: the motors do not carry it
  std::int64_t retries = 3;
};

/// What the guardian says about the flight.
struct MissionSafety {
  std::uint32_t permitted = 1;  // to arm; a bool would leave padding in a state
  msg::FailsafeAction action = msg::FailsafeAction::none;
};

/// What to fly: arm, climb, search, approach, hold, descend, touch down, disarm; or come down where it is.
/// Frames:  world of NavState, z up.
/// Safety:  never arms without a valid estimate. Without position for estimate_lost_s, after too many lost pads, when
///          it falls, or when its time is up it aborts: sinks slowly and disarms on the ground, after blind_s without
///          height, and after abort_limit_s in any case: motors never turn on the ground for ever. It waits for the
///          guardian's permission; when that ends in flight, the mission is done. A failsafe's `land` aborts in the
///          air; on the ground the mission goes back to waiting.
/// Thread:  owner.   RT: yes.
class MissionPlan {
 public:
  MissionParams params;

  void reset();
  /// Valid until the next call; at first everything is permitted.
  void set_safety(const MissionSafety& safety) { safety_ = safety; }
  /// A mate has told where the pad is: the search begins there. It stays known.
  void set_told_pad(const math::Vec3& p_world_m) {
    told_pad_m_ = p_world_m;
    told_ = 1;
  }
  /// Of a mate that lands first, each step: it is waited for on the ground until it has landed, or was not heard for
  /// ahead_silent_s. Null: not heard.
  void set_ahead(const msg::MissionPhase* phase, double dt_s) {
    ahead_silent_s_ = phase ? 0 : ahead_silent_s_ + dt_s;
    waits_ = phase ? *phase != msg::MissionPhase::done : ahead_silent_s_ < params.ahead_silent_s;
  }
  /// A landing is flown by somebody else, each step: from the search on, where the pad is seen, its velocity in world
  /// axes takes the place of approach, hold and descent. Null: it is silent; the vehicle hovers, or sinks slowly where
  /// it is so low that it lands without further sightings.
  void set_guide(const math::Vec3* v_world_mps) {
    guided_ = 1;
    guide_silent_ = v_world_mps ? 0 : 1;
    guide_mps_ = v_world_mps ? *v_world_mps : math::Vec3{};
  }
  /// One step at `now` with the newest estimate; dt since the last step.
  void step(msg::Time now, const msg::NavState& nav, double dt_s);
  /// Instead of step() while a pilot flies by hand: the setpoint follows the vehicle. When the pilot hands back in
  /// flight, the vehicle comes down where it is: the earlier plan is over.
  void stand_by(msg::Time now, const msg::NavState& nav);
  const msg::FlightSetpoint& setpoint() const { return setpoint_; }
  const msg::MissionState& state() const { return state_; }

 private:
  void enter(msg::MissionPhase phase, msg::Time now);
  double in_phase_s(msg::Time now) const { return msg::seconds(now - state_.phase_since); }
  bool flying() const;
  void obey(msg::Time now);
  bool pad_fresh(const msg::NavState& nav) const;
  bool arrived(const msg::NavState& nav) const;
  bool touched(const msg::NavState& nav, double dt_s);
  void run_phase(msg::Time now, const msg::NavState& nav, double dt_s);
  void run_search(msg::Time now, const msg::NavState& nav, double dt_s);
  void run_descend(msg::Time now, const msg::NavState& nav, double dt_s);
  void run_guided(msg::Time now, const msg::NavState& nav, double dt_s);
  bool committed(const msg::NavState& nav) const;
  void run_abort(msg::Time now, const msg::NavState& nav, double dt_s);
  void lose_pad(msg::Time now);
  math::Vec3 above_landing(const msg::NavState& nav) const;
  /// Moves the reference towards the target with limited speed and acceleration.
  void slew(double dt_s);
  void fly_reference();

  msg::FlightSetpoint setpoint_;
  msg::MissionState state_;
  MissionSafety safety_;
  math::Vec3 told_pad_m_;
  math::Vec3 target_m_, reference_m_, reference_mps_, search_centre_m_;
  double yaw_rad_ = 0;
  double valid_s_ = 0, invalid_s_ = 0, touch_s_ = 0, stuck_s_ = 0, blind_s_ = 0, arrived_s_ = 0;
  std::int64_t search_leg_ = 0, lost_ = 0;
  msg::Time armed_at_;
  std::uint64_t begun_ = 0;  // likewise
  double ahead_silent_s_ = 0;
  std::uint64_t told_ = 0, waits_ = 0;
  math::Vec3 guide_mps_;
  std::uint64_t guided_ = 0, guide_silent_ = 0;
};

}  // namespace sinew::control
