#include "motion/one_foot.hpp"

#include <algorithm>

#include "motion/posture.hpp"

namespace sinew::motion {
namespace {

constexpr double kSmooth_s = 0.01;
constexpr double kMostTurn_rad = 0.3;
constexpr double kFree_m = 0.002;  // a sole that is higher does not turn with the ankle that balances

}  // namespace

OneFoot::OneFoot(const Figure& figure, const WalkParams& walk, std::span<const double> rest_rad)
    : figure_(&figure), lead_(figure), walk_(walk) {
  std::copy_n(rest_rad.begin(), std::min(rest_rad.size(), figure.joints()), rest_rad_.begin());
}

void OneFoot::start() {
  rate_ = {};
  lead_.reset();
}

void OneFoot::step(Side free_side, const FreeFoot& at, const OneFootBalance& balance, const math::Quat& q_world_torso,
                   const math::Vec3& rate_radps, double dt_s, std::span<double> targets_rad) {
  rate_ += (rate_radps - rate_) * (dt_s / (dt_s + kSmooth_s));

  WalkParams stand = walk_;
  stand.height_m += at.tall * balance.taller_m;
  stand.lean_rad -= at.tall * balance.less_lean_rad;
  const TorsoOffsets offsets = torso_offsets(*figure_, stand, rest_rad_);
  // The frame of the carrying sole.
  const double toward = sign(free_side);
  const Vec2 foot = Vec2{0, toward * walk_.stance_m} + at.from_place_m;
  const Vec2 middle = Vec2{walk_.com_forward_m, 0} + 0.5 * foot;
  const Vec2 above{balance.com_m.x, toward * balance.com_m.y};
  const Vec2 com = middle + at.over * (above - middle);
  const math::Quat planned = math::Quat::from_axis_angle({0, 1, 0}, stand.lean_rad - at.lean_back_rad) *
                             math::Quat::from_axis_angle({1, 0, 0}, toward * at.lean_away_rad);
  const Vec2 torso_at = com - Vec2{offsets.com_m.x, offsets.com_m.y};
  const kinematics::Pose to_torso =
      kinematics::Pose{{torso_at.x, torso_at.y, stand.height_m - at.torso_down_m + offsets.over_hips_m}, planned}
          .inverse();
  const Lean lean = lean_beside(q_world_torso, planned);
  const double pitch =
      std::clamp(balance.gyro_pitch_s * rate_.y + balance.tilt_pitch * lean.pitch_rad, -kMostTurn_rad, kMostTurn_rad);
  const double roll =
      std::clamp(balance.gyro_roll_s * rate_.x + balance.tilt_roll * lean.roll_rad, -kMostTurn_rad, kMostTurn_rad);

  std::copy_n(rest_rad_.begin(), figure_->joints(), targets_rad.begin());
  std::array<LegLoad, 2> loads{};
  const double weight_n = figure_->mass_kg() * 9.81;
  for (const Side side : kSides) {
    const bool carries = side != free_side;
    const bool is_up = !carries && at.up_m > kFree_m;
    const math::Quat turn =
        is_up ? math::Quat::from_axis_angle({0, 1, 0}, at.pitch_rad) *
                    math::Quat::from_axis_angle({1, 0, 0}, toward * at.roll_rad)
              : math::Quat::from_axis_angle({0, 1, 0}, pitch) * math::Quat::from_axis_angle({1, 0, 0}, roll);
    const kinematics::Pose sole{carries ? math::Vec3{} : math::Vec3{foot.x, foot.y, at.up_m}, turn};
    figure_->place_sole(side, to_torso * sole, targets_rad);
    const double share = carries ? 0.5 + 0.5 * at.over : 0.5 - 0.5 * at.over;
    const Vec2 push = carries ? above : foot;
    loads[index(side)] = {to_torso.q.rotate({0, 0, share * weight_n}), to_torso.of({push.x, push.y, 0})};
  }
  for (const Side side : kSides)
    if (const std::size_t shoulder = figure_->shoulder_pitch(side); shoulder != kinematics::kNone)
      targets_rad[shoulder] += (side == free_side ? 1 : -1) * at.arms_rad;
  lead_.step({walk_.lead_s, walk_.servo_gain_per_rad, walk_.weight_ahead, walk_.play_rad}, loads, dt_s,
             targets_rad.first(figure_->joints()));
  figure_->limit(targets_rad);
}

FreeFoot along_way(std::span<const FootPlace> way, double time_s) {
  FreeFoot before;
  for (const FootPlace& to : way) {
    if (time_s >= to.lasts_s) {
      time_s -= to.lasts_s;
      before = to.foot;
      continue;
    }
    const double part = time_s / to.lasts_s, share = to.sharp ? part : part * part * (3 - 2 * part);
    const auto between = [share](double a, double b) { return a + share * (b - a); };
    const FreeFoot& f = to.foot;
    return {.over = between(before.over, f.over),
            .from_place_m = before.from_place_m + share * (f.from_place_m - before.from_place_m),
            .up_m = between(before.up_m, f.up_m),
            .pitch_rad = between(before.pitch_rad, f.pitch_rad),
            .roll_rad = between(before.roll_rad, f.roll_rad),
            .lean_back_rad = between(before.lean_back_rad, f.lean_back_rad),
            .lean_away_rad = between(before.lean_away_rad, f.lean_away_rad),
            .torso_down_m = between(before.torso_down_m, f.torso_down_m),
            .tall = between(before.tall, f.tall),
            .arms_rad = between(before.arms_rad, f.arms_rad)};
  }
  return before;
}

double duration_s(std::span<const FootPlace> way) {
  double sum = 0;
  for (const FootPlace& to : way) sum += to.lasts_s;
  return sum;
}

}  // namespace sinew::motion
