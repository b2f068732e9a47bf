// Steps of the walk: how fast, where to, when.
#include "motion/walk.hpp"

#include <algorithm>

namespace sinew::motion {
namespace {

constexpr double kLeast_s = 0.03;  // of the rest of a step that is still planned with

double smooth(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// From 0 to 1 with a speed that rises for a part `ramp` of the time, stays, and falls for such a part.
double ramped(double x, double ramp) {
  x = std::clamp(x, 0.0, 1.0);
  const double end = std::min(x, 1 - x), most = 1 / (1 - ramp);
  const double way = end < ramp ? 0.5 * most * end * end / ramp : most * (end - 0.5 * ramp);
  return x < 0.5 ? way : 1 - way;
}
double approach(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

}  // namespace

void Walk::choose_speed(const WalkCommand& command) {
  WalkCommand wanted = command.walk ? command : WalkCommand{};
  wanted.forward_mps = std::clamp(wanted.forward_mps, -params.most_back_mps, params.most_forward_mps);
  wanted.left_mps = std::clamp(wanted.left_mps, -params.most_side_mps, params.most_side_mps);
  wanted.turn_radps = std::clamp(wanted.turn_radps, -params.most_turn_radps, params.most_turn_radps);
  // Together no more than one of them alone may be.
  const double forward = wanted.forward_mps / (wanted.forward_mps < 0 ? params.most_back_mps : params.most_forward_mps);
  const double share = math::fabs(forward) + math::fabs(wanted.left_mps) / params.most_side_mps +
                       math::fabs(wanted.turn_radps) / params.most_turn_radps;
  const double scale = share > 1 ? 1 / share : 1;
  wanted.forward_mps *= wanted.forward_mps > 0 ? params.scale_forward : params.scale_back;
  wanted.left_mps *= params.scale_side;
  wanted.turn_radps *= params.scale_turn;
  const double t = period();
  speed_.forward_mps = approach(speed_.forward_mps, scale * wanted.forward_mps, params.accel_mps2 * t);
  speed_.left_mps = approach(speed_.left_mps, scale * wanted.left_mps, params.accel_mps2 * t);
  speed_.turn_radps = approach(speed_.turn_radps, scale * wanted.turn_radps, params.turn_accel_radps2 * t);
  speed_.walk = command.walk;
}

/// Where the foot has to land for the wanted speed, and the dcm of a steady walk then.
Walk::Goal Walk::goal() const {
  const double t = period(), toward = sign(other(support_));
  double turn = speed_.turn_radps;
  // The heading that was lost is walked back.
  turn += std::clamp(params.heading_per_s * math::wrap_pi(heading_rad_ - q_now_.yaw()), -0.5, 0.5);
  const double open_rad = 2 * math::fabs(turn) * t, in_rad = std::min(params.toe_in_rad, 0.5 * open_rad);
  const bool opens = toward * turn > 0;
  const double yaw_rad = toward * (opens ? open_rad - in_rad : -in_rad);
  const double rest_m = wanted_distance();
  const bool aside = toward * speed_.left_mps > 0;
  const double wide_m = rest_m + 2 * math::fabs(speed_.left_mps) * t;
  const double this_m = aside ? wide_m : rest_m, next_m = aside || speed_.left_mps == 0 ? rest_m : wide_m;
  const double inside = params.cop_inside_m, length_m = speed_.forward_mps * t, w = params.omega_radps;

  Goal goal;
  goal.foot = {turned({length_m, toward * this_m}, 0.5 * yaw_rad), yaw_rad};
  // The dcm that steps of the usual period begin with; after one that is longer it is to be that again.
  const double usual_s = params.period_s;
  double ahead_m = speed_.forward_mps * usual_s / (math::exp(w * usual_s) - 1);
  double beside_m = steady_dcm(next_m - 2 * inside, this_m - 2 * inside, w, usual_s);
  if (prepares_) {
    const double kick_s = kick_params().stretch * usual_s, shrink = math::exp(-w * kick_s);
    ahead_m = (ahead_m + speed_.forward_mps * kick_s) * shrink;
    beside_m = (next_m - 2 * inside - steady_dcm(this_m - 2 * inside, next_m - 2 * inside, w, usual_s)) * shrink;
  }
  ahead_m += params.com_forward_m;
  beside_m += inside;
  goal.dcm_m = goal.foot.at_m + turned({ahead_m, -toward * beside_m}, yaw_rad);
  return goal;
}

void Walk::kick(Side foot, KickWay way) {
  wants_kick_ = true;
  kick_foot_ = foot;
  kick_way_ = way;
}

void Walk::begin_step() {
  phase_ = WalkPhase::step;
  kicking_ = prepares_;
  if (kicking_) wants_kick_ = false;
  prepares_ = wants_kick_ && support_ == kick_foot_;
  choose_speed(command_);
  time_s_ = 0;
  touch_s_ = 0;
  swung_ = 0;
  end_s_ = period();
  lifted_ = foot_;
  lifted_z_m_ = foot_z_m_;
  support_z0_m_ = support_z_m_;
  landing_ = goal().foot;
}

Vec2 Walk::push_under_sole(const Goal& goal, double left_s) {
  const double toward = sign(other(support_));
  const Vec2 rest{params.com_forward_m, toward * params.cop_inside_m};
  const auto along = [&](double dcm_m, double wanted_m, double rest_m, double most_m) {
    return std::clamp(cop_for(dcm_m, wanted_m, params.omega_radps, left_s), rest_m - most_m, rest_m + most_m);
  };
  return {along(plan_.x.dcm_m, goal.dcm_m.x, rest.x, params.cop_most_x_m),
          along(plan_.y.dcm_m, goal.dcm_m.y, rest.y, params.cop_most_y_m)};
}

void Walk::advance_step(double dt_s) {
  const double toward = sign(other(support_)), t = period();
  const Goal goal = this->goal();
  // When: the sway's own time.
  const double free_s =
      time_until(toward * plan_.y.dcm_m, toward * goal.dcm_m.y, params.cop_inside_m, params.omega_radps);
  const double least_s = params.time_least * t, most_s = params.time_most * t;
  const double sway_s = std::clamp(time_s_ + free_s, least_s, most_s);
  const double planned_s = t + params.time_gain * (sway_s - t);
  end_s_ = std::max(planned_s, time_s_);
  // A foot that could not be put far enough is put down sooner.
  const Vec2 beyond = goal.dcm_m - goal.foot.at_m;
  const double push_x = params.com_forward_m;
  for (const double way : {1.0, -1.0}) {
    const double far_s = time_until(plan_.x.dcm_m, way * params.most_step_x_m + beyond.x,
                                    push_x + way * params.cop_most_x_m, params.omega_radps);
    if (way * (plan_.x.dcm_m - push_x) > params.cop_most_x_m)
      end_s_ = std::min(end_s_, std::max({least_s, time_s_, time_s_ + far_s}));
  }
  const double wide_s = time_until(toward * plan_.y.dcm_m, params.most_step_y_m + toward * beyond.y,
                                   params.cop_inside_m + params.cop_most_y_m, params.omega_radps);
  if (toward * plan_.y.dcm_m > params.cop_inside_m + params.cop_most_y_m)
    end_s_ = std::min(end_s_, std::max({least_s, time_s_, time_s_ + wide_s}));
  const double left_s = std::max(end_s_ - time_s_, kLeast_s);

  // Where: what the push under the sole cannot do is left to the next sole.
  cop_m_ = push_under_sole(goal, left_s);
  const double e = math::exp(params.omega_radps * left_s);
  const Vec2 off{cop_m_.x + (plan_.x.dcm_m - cop_m_.x) * e - goal.dcm_m.x,
                 cop_m_.y + (plan_.y.dcm_m - cop_m_.y) * e - goal.dcm_m.y};
  landing_ = goal.foot;
  landing_.at_m.x = std::clamp(goal.foot.at_m.x + params.adjust_x * off.x, -params.most_step_x_m, params.most_step_x_m);
  landing_.at_m.y = toward * std::clamp(toward * (goal.foot.at_m.y + params.adjust_y * off.y), params.least_feet_m,
                                        params.most_step_y_m);
  plan_.x = plan_.x.later(cop_m_.x, params.omega_radps, dt_s);
  plan_.y = plan_.y.later(cop_m_.y, params.omega_radps, dt_s);
  time_s_ += dt_s;
  heading_rad_ += speed_.turn_radps / params.scale_turn * dt_s;
  move_foot(landing_, dt_s);

  const Stance& s = stance();
  const bool touched = time_s_ > params.switch_least * t && s.load[index(other(support_))] > params.contact_share;
  const bool over = time_s_ >= end_s_;
  if (touched && touch_s_ == 0) touch_s_ = time_s_;
  if ((over && touch_s_ > 0) || touched || time_s_ >= planned_s + params.switch_grace_s) end_step();
}

void Walk::move_foot(const Planar& to, double dt_s) {
  const double at = time_s_ / end_s_;
  const double way = ramped((at - params.swing_begin) / (params.swing_end - params.swing_begin), params.swing_ramp);
  if (way > swung_ && swung_ < 1) {
    const double part = (way - swung_) / (1 - swung_);
    Vec2 move = part * (to.at_m - foot_.at_m);
    const double far = norm(move), most = params.most_swing_mps * dt_s;
    if (far > most) move = (most / far) * move;
    foot_.at_m = foot_.at_m + move;
    foot_.yaw_rad += part * (to.yaw_rad - foot_.yaw_rad);
    swung_ = way;
  } else if (swung_ >= 1) {
    Vec2 move = to.at_m - foot_.at_m;
    const double far = norm(move), most = 0.3 * params.most_swing_mps * dt_s;
    if (far > most) move = (most / far) * move;
    if (stance().load[index(other(support_))] < 0.05) foot_.at_m = foot_.at_m + move;
  }
  const double peak = params.lift_peak;
  const double up = at < peak ? smooth(at / peak) : 1 - smooth((at - peak) / (1 - peak));
  foot_z_m_ = lifted_z_m_ * (1 - smooth(at)) + params.lift_m * up;
  support_z_m_ = support_z0_m_ * (1 - smooth(at / 0.6));
}

/// The other sole is the frame from now on.
void Walk::change_support(const Planar& new_support) {
  const Planar to_new = new_support.inverse();
  const Vec2 c = to_new.of({plan_.x.com_m, plan_.y.com_m}), d = to_new.of({plan_.x.dcm_m, plan_.y.dcm_m});
  plan_.x = {c.x, d.x};
  plan_.y = {c.y, d.y};
  yaw0_rad_ = torso_yaw() - new_support.yaw_rad;
  frame_yaw_rad_ += new_support.yaw_rad;
  foot_ = to_new;
  std::swap(foot_z_m_, support_z_m_);
  support_ = other(support_);
}

void Walk::end_step() {
  change_support(foot_);
  ++steps_;
  const bool still = speed_.forward_mps == 0 && speed_.left_mps == 0 && speed_.turn_radps == 0;
  stopping_ = !command_.walk && still ? stopping_ + 1 : 0;
  if (stopping_ >= 3) {
    phase_ = WalkPhase::stand;
    time_s_ = 0;
    kicking_ = wants_kick_ = prepares_ = false;
    return;
  }
  begin_step();
}

}  // namespace sinew::motion
