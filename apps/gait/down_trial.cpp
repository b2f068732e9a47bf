#include "apps/gait/down_trial.hpp"

#include <algorithm>

namespace sinew::gait {
namespace {

constexpr double kStandFirst_s = 1, kLieLimp_s = 2, kMostDown_s = 10;
constexpr double kGently_radps = 2;  // as the world's walk_score.cpp

}  // namespace

std::optional<DownResult> run_down(const GaitSetup& setup, std::uint64_t seed, std::string& why) {
  const std::vector<motion::KeyPose>* poses = setup.book.find(kGetDown);
  if (poses == nullptr) {
    why = std::string("the motion file has no motion ") + kGetDown;
    return std::nullopt;
  }
  const auto rig = Rig::create(setup, seed, why);
  if (!rig) return std::nullopt;
  motion::Walk walk = rig->make_walk();
  walk.reset(rig->sense());
  motion::PosePlayer player;
  DownResult out;
  double down_s = -1, limp_s = -1;
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kStandFirst_s;
    if (t_s > kMostDown_s || (limp_s >= 0 && t_s > limp_s + kLieLimp_s)) break;
    const motion::Sensed sensed = rig->sense();
    out.blow_mps2 = std::max(out.blow_mps2, math::norm(sensed.accel_mps2));
    if (t_s < 0) {
      walk.step({}, sensed, kControl_s, rig->targets());
    } else {
      if (player.state() == motion::PosePlayer::State::idle) player.start(*poses, sensed.joints_rad);
      walk.sense_only(sensed, kControl_s);
      player.step(walk.tilt.up(), kControl_s, rig->targets());
    }
    const bool ended =
        player.state() == motion::PosePlayer::State::done || player.state() == motion::PosePlayer::State::failed;
    if (ended && limp_s < 0) limp_s = t_s;
    if (limp_s >= 0) std::ranges::fill(rig->targets(), math::kNan);
    rig->act(rig->targets());
    const plant::BodyTruth& truth = rig->truth();
    if (truth.fallen && down_s < 0) {
      down_s = t_s;
      out.gently = math::norm(truth.gyro_radps) < kGently_radps;
    }
  }
  const plant::BodyTruth& truth = rig->truth();
  out.time_s = down_s;
  out.lies = limp_s >= 0 && motion::lying(truth.torso.q.conjugate().rotate({0, 0, 1})) == motion::FallWay::front;
  out.gently = out.gently && out.lies;
  return out;
}

}  // namespace sinew::gait
