#include "motion/kick.hpp"

#include <algorithm>

#include "motion/posture.hpp"

namespace sinew::motion {
namespace {

constexpr double kSmooth_s = 0.01;
constexpr double kMostTurn_rad = 0.3;

}  // namespace

Kick::Kick(const Figure& figure, const WalkParams& walk, std::span<const double> rest_rad)
    : figure_(&figure), lead_(figure), walk_(walk) {
  std::copy_n(rest_rad.begin(), std::min(rest_rad.size(), figure.joints()), rest_rad_.begin());
  const TorsoOffsets offsets = torso_offsets(figure, walk, rest_rad_);
  com_in_torso_ = offsets.com_m;
  torso_over_hips_m_ = offsets.over_hips_m;
}

std::array<Kick::Frame, 8> Kick::frames() const {
  const KickParams& p = params;
  const double back = way_ == KickWay::forward ? -p.back_m : -p.side_back_m;
  const double strike = way_ == KickWay::forward ? p.strike_m : p.side_strike_m;
  const bool ahead = way_ == KickWay::forward;
  const double down = ahead ? p.back_pitch_rad : 0, up = ahead ? -p.strike_pitch_rad : 0;
  std::array<Frame, 8> f{{{0, p.shift_s, 1, 0, 0, 0, false},
                          {0, p.lift_s, 1, back, p.lift_m, down, false},
                          {0, p.still_s, 1, back, p.lift_m, down, false},
                          {0, p.strike_s, 1, strike, p.strike_lift_m, up, true},
                          {0, p.follow_s, 1, strike, p.strike_lift_m, up, false},
                          {0, p.return_s, 1, 0, p.lift_m, 0, false},
                          {0, p.lower_s, 1, 0, 0, 0, false},
                          {0, p.shift_s, 0, 0, 0, 0, false}}};
  for (std::size_t i = 1; i < f.size(); ++i) f[i].begin_s = f[i - 1].begin_s + f[i - 1].lasts_s;
  return f;
}

double Kick::lasts_s() const {
  const Frame last = frames().back();
  return last.begin_s + last.lasts_s;
}

void Kick::start(Side foot, KickWay way) {
  foot_ = foot;
  way_ = way;
  time_s_ = 0;
  active_ = true;
  rate_ = {};
  lead_.reset();
}

void Kick::step(const math::Quat& q_world_torso, const math::Vec3& rate_radps, double dt_s,
                std::span<double> targets_rad) {
  rate_ += (rate_radps - rate_) * (dt_s / (dt_s + kSmooth_s));
  time_s_ += dt_s;
  const std::array<Frame, 8> all = frames();
  Frame before{0, 0, 0, 0, 0, 0, false}, to = all.back();
  double part = 1;
  for (const Frame& f : all) {
    if (time_s_ < f.begin_s + f.lasts_s) {
      to = f;
      part = (time_s_ - f.begin_s) / f.lasts_s;
      break;
    }
    before = f;
  }
  if (time_s_ >= lasts_s()) active_ = false;
  const double way = to.sharp ? part : part * part * (3 - 2 * part);
  const auto between = [&](double Frame::*value) { return before.*value + way * (to.*value - before.*value); };
  const double over = between(&Frame::over), along = between(&Frame::along), up = between(&Frame::up);
  const bool carries_alone = over > 0.999;

  // The frame of the carrying sole.
  const double toward = sign(foot_);
  const Vec2 middle{walk_.com_forward_m, toward * 0.5 * walk_.stance_m};
  const Vec2 above{params.com_forward_m, toward * params.com_inside_m};
  const Vec2 com = middle + over * (above - middle);
  const Vec2 direction = way_ == KickWay::forward ? Vec2{1, 0} : Vec2{0, toward};
  const Vec2 foot = Vec2{0, toward * walk_.stance_m} + along * direction;
  const double strike =
      carries_alone ? std::max(0.0, along) / (way_ == KickWay::forward ? params.strike_m : params.side_strike_m) : 0;
  const math::Quat planned = math::Quat::from_axis_angle(
      {0, 1, 0}, walk_.lean_rad - (way_ == KickWay::forward ? over * params.lean_back_rad : 0));
  const Vec2 torso_at = com - com_in_torso_;
  const kinematics::Pose to_torso =
      kinematics::Pose{{torso_at.x, torso_at.y, walk_.height_m + torso_over_hips_m_}, planned}.inverse();
  const Lean lean = lean_beside(q_world_torso, planned);
  const double pitch =
      std::clamp(params.gyro_pitch_s * rate_.y + params.tilt_pitch * lean.pitch_rad, -kMostTurn_rad, kMostTurn_rad);
  const double roll =
      std::clamp(params.gyro_roll_s * rate_.x + params.tilt_roll * lean.roll_rad, -kMostTurn_rad, kMostTurn_rad);

  std::copy_n(rest_rad_.begin(), figure_->joints(), targets_rad.begin());
  std::array<LegLoad, 2> loads{};
  const double weight_n = figure_->mass_kg() * 9.81;
  for (const Side side : kSides) {
    const bool carries = side != foot_;
    const bool free = !carries && up > 0.002;
    const math::Quat turn =
        free ? math::Quat::from_axis_angle({0, 1, 0}, between(&Frame::pitch_rad))
             : math::Quat::from_axis_angle({0, 1, 0}, pitch) * math::Quat::from_axis_angle({1, 0, 0}, roll);
    const kinematics::Pose sole{carries ? math::Vec3{} : math::Vec3{foot.x, foot.y, up}, turn};
    figure_->place_sole(side, to_torso * sole, targets_rad);
    const double share = carries ? 0.5 + 0.5 * over : 0.5 - 0.5 * over;
    const Vec2 push = carries ? above : foot;
    loads[index(side)] = {to_torso.q.rotate({0, 0, share * weight_n}), to_torso.of({push.x, push.y, 0})};
  }
  for (const Side side : kSides)
    if (const std::size_t shoulder = figure_->shoulder_pitch(side); shoulder != kinematics::kNone)
      targets_rad[shoulder] += (side == foot_ ? 1 : -1) * params.arm_swing_rad * strike;
  lead_.step({walk_.lead_s, walk_.servo_gain_per_rad, walk_.weight_ahead, walk_.play_rad}, loads, dt_s,
             targets_rad.first(figure_->joints()));
  figure_->limit(targets_rad);
}

}  // namespace sinew::motion
