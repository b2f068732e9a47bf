#include "apps/gait/rise_trial.hpp"

#include <algorithm>

#include "math/random.hpp"

namespace sinew::gait {
namespace {

constexpr double kLie_s = 0.5, kMostRise_s = 5, kStay_s = 1.5, kEnd_s = kMostRise_s + kStay_s;
constexpr double kUp = 0.94;  // 20 degrees

}  // namespace

std::optional<RiseResult> run_rise(const GaitSetup& setup, const std::string& name, std::uint64_t seed,
                                   std::string& why) {
  const std::vector<motion::KeyPose>* poses = setup.book.find(name);
  if (poses == nullptr) {
    why = "the motion file has no motion " + name;
    return std::nullopt;
  }
  // As it fell: on its front or back, turned a little, arms and legs near their standing pose.
  math::Random random(seed, 0x415e);
  const auto standing = Rig::create(setup, seed, why);
  if (!standing) return std::nullopt;
  plant::PitchPlace start;
  start.lie =
      name.find("back") != std::string::npos ? plant::PitchPlace::Lie::on_back : plant::PitchPlace::Lie::on_front;
  start.heading_rad = random.uniform(-math::kPi, math::kPi);
  for (const double rad : standing->targets()) start.joints_rad.push_back(rad + random.uniform(-0.15, 0.15));
  const auto rig = Rig::create(setup, seed, why, start);
  if (!rig) return std::nullopt;

  const double stands_m = standing->truth().torso.p_m.z;
  motion::Walk walk = rig->make_walk();
  motion::Tilt tilt;
  motion::PosePlayer player;
  RiseResult out;
  double upright_since_s = -1, sum = 0, counted = 0;
  bool walking = false;
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kLie_s;
    if (t_s > kEnd_s) break;
    const motion::Sensed sensed = rig->sense();
    if (tick == 0) tilt.start(sensed.accel_mps2);
    tilt.step(sensed.gyro_radps, sensed.accel_mps2, false, kControl_s);
    if (t_s >= 0 && player.state() == motion::PosePlayer::State::idle) player.start(*poses, sensed.joints_rad);
    const bool done = player.state() == motion::PosePlayer::State::done;
    if (!done || !walking) player.step(tilt.up(), kControl_s, rig->targets());
    if (player.state() == motion::PosePlayer::State::done && !walking) {
      walk.reset(sensed);
      walking = true;
    }
    if (walking) walk.step({}, sensed, kControl_s, rig->targets());
    rig->act(rig->targets());

    const plant::BodyTruth& truth = rig->truth();
    out.up = truth.torso.q.rotate({0, 0, 1}).z;
    out.height_m = truth.torso.p_m.z;
    out.load = (truth.foot_n[0] + truth.foot_n[1]) / (rig->figure().mass_kg() * 9.81);
    const bool stands = out.up > kUp && out.height_m > 0.85 * stands_m && !truth.body_down;
    if (!stands) upright_since_s = -1;
    if (stands && upright_since_s < 0) upright_since_s = t_s;
    if (t_s >= 0) {
      const double load = std::clamp(out.load, 0.0, 1.0);
      const double upright = 0.5 * (1 + out.up);  // feet that touch each other bear nothing
      const double lacks =
          1 - 0.4 * upright - 0.3 * std::clamp(out.height_m / stands_m, 0.0, 1.0) - 0.3 * load * upright;
      sum += t_s * lacks;  // the end counts most
      counted += t_s;
      out.from_front = std::min(out.from_front, 0.5 * (1 + truth.torso.q.rotate({1, 0, 0}).z));
      if (player.state() == motion::PosePlayer::State::failed) {  // it remains as it is
        const double rest = 0.5 * (kEnd_s * kEnd_s - t_s * t_s) / kControl_s;
        sum += rest * lacks;
        counted += rest;
        break;
      }
    }
  }
  out.stood =
      upright_since_s >= 0 && upright_since_s <= kMostRise_s && player.state() == motion::PosePlayer::State::done;
  out.time_s = upright_since_s;
  out.shortfall = sum / counted;
  return out;
}

}  // namespace sinew::gait
