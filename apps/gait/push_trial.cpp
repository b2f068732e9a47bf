#include "apps/gait/push_trial.hpp"

#include <algorithm>

#include "math/random.hpp"

namespace sinew::gait {
namespace {

constexpr double kBeforePush_s = 1.5, kWalkBeforePush_s = 3, kAfterPush_s = 5, kImpact_s = 0.5;

std::string fall_motion(motion::FallWay way) {
  switch (way) {
    case motion::FallWay::front:
      return "fall_front";
    case motion::FallWay::back:
      return "fall_back";
    case motion::FallWay::left:
      return "fall_left";
    case motion::FallWay::right:
      return "fall_right";
    case motion::FallWay::none:
      break;
  }
  return {};
}

/// Torques on the gears of legs and arms, in each step of the plant.
class GearLoads {
 public:
  explicit GearLoads(const kinematics::Body& body) : body_(&body) {}

  void step(const plant::BodyTruth& truth, PushResult& out) {
    const double dt_s = 1e-9 * static_cast<double>(plant::kPitchStepNs);
    for (std::size_t j = 0; j < body_->joints(); ++j) {
      const kinematics::Link& link = body_->links[j + 1];
      if (link.servo >= body_->servos.size() || link.name.starts_with("head")) continue;
      const double change = truth.joint_radps[j] - before_[j];
      before_[j] = truth.joint_radps[j];
      const double inertia = body_->servos[link.servo].armature_kgm2;
      recent_[j][next_] = inertia * change;
      double within_10_ms = 0;
      for (const double one : recent_[j]) within_10_ms += one;
      if (!counts_) continue;
      out.impact_nms = std::max(out.impact_nms, math::fabs(within_10_ms));
      out.gear_nm = std::max(out.gear_nm, inertia * math::fabs(change) / dt_s);
    }
    next_ = (next_ + 1) % recent_[0].size();
  }
  void count() { counts_ = true; }

 private:
  const kinematics::Body* body_;
  std::array<double, plant::kMostJoints> before_{};
  std::array<std::array<double, 5>, plant::kMostJoints> recent_{};
  std::size_t next_ = 0;
  bool counts_ = false;
};

}  // namespace

std::optional<PushResult> run_push(const GaitSetup& setup, const PushTrial& trial, std::string& why) {
  const auto rig = Rig::create(setup, trial.seed, why);
  if (!rig) return std::nullopt;
  motion::Walk walk = rig->make_walk();
  motion::FallDetector detector(setup.book.fall);
  motion::PosePlayer player;
  walk.reset(rig->sense());
  GearLoads loads(setup.body);
  math::Random random(trial.seed, 0x9054);
  const double push_s = kWalkBeforePush_s + random.uniform(0, 2 * setup.book.walk.period_s);
  PushResult out;
  double seen_s = -1, hit_s = -1;
  bool pushed = false, gave_way = false;
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kBeforePush_s;
    if (t_s > push_s + kAfterPush_s || (hit_s >= 0 && t_s > hit_s + kImpact_s)) break;
    if (!pushed && t_s >= push_s) {
      pushed = true;
      const double to = rig->truth().torso.q.yaw() + trial.direction_rad;
      const double impulse_ns = trial.speed_mps * rig->figure().mass_kg();
      rig->pitch().push(0, {impulse_ns * math::cos(to), impulse_ns * math::sin(to), 0},
                        static_cast<std::int64_t>(trial.lasts_s * 1e9));
    }
    const motion::Sensed sensed = rig->sense();
    const motion::WalkCommand command{.forward_mps = trial.forward_mps, .walk = t_s >= 0};
    walk.step(command, sensed, kControl_s, rig->targets());
    detector.step(walk.q_world_torso().conjugate().rotate({0, 0, 1}), walk.tilt.rate_radps(), kControl_s);
    if (detector.way() == motion::FallWay::none) seen_s = -1;  // not yet, or taken back
    if (detector.way() != motion::FallWay::none && seen_s < 0) seen_s = t_s;
    if (trial.react && detector.gives_way() && !gave_way) {
      gave_way = true;
      for (std::size_t j = 0; j < rig->figure().joints(); ++j) rig->pitch().limit(0, j, setup.book.fall.relax_share);
      if (const auto* poses = setup.book.find(fall_motion(detector.way()))) player.start(*poses, sensed.joints_rad);
    }
    player.step(walk.tilt.up(), kControl_s, rig->targets());
    rig->pitch().command(0, rig->targets());
    for (int i = 0; i < kPlantSteps; ++i) {
      rig->pitch().step();
      const plant::BodyTruth& truth = rig->truth();
      if (hit_s < 0 && (truth.body_down || truth.fallen)) {
        hit_s = t_s + (i + 1) * kControl_s / kPlantSteps;
        loads.count();
      }
      loads.step(truth, out);
    }
  }
  out.fell = hit_s >= 0;
  out.fell_before = hit_s >= 0 && hit_s < push_s;
  out.seen = seen_s >= 0;
  out.hit_after_s = out.fell ? hit_s - push_s : 0;
  out.ahead_s = out.fell && out.seen ? hit_s - seen_s : 0;
  return out;
}

}  // namespace sinew::gait
