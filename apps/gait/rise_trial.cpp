#include "apps/gait/rise_trial.hpp"

#include <algorithm>
#include <memory>

#include "math/random.hpp"
#include "motion/pose_motions.hpp"

namespace sinew::gait {
namespace {

using motion::FallWay;
using motion::PosePlayer;
using Lie = plant::PitchPlace::Lie;

constexpr double kLie_s = 0.5, kStay_s = 1.5;
constexpr double kEnd_s = most_rise_s(FallWay::front) + kStay_s;  // of one motion
constexpr double kUp = 0.94;                                      // 20 degrees
constexpr double kAgain_s = 0.7;                                  // at rest between two motions, as kid::Mover waits

constexpr Lie place_of(FallWay lies_on) {
  switch (lies_on) {
    case FallWay::back:
      return Lie::on_back;
    case FallWay::left:
      return Lie::on_left;
    case FallWay::right:
      return Lie::on_right;
    case FallWay::front:
    case FallWay::none:
      return Lie::on_front;
  }
  return Lie::on_front;
}

struct Fallen {
  std::unique_ptr<Rig> rig;
  double stands_m = 0;  // height of the torso in the standing pose
};

/// As it fell: turned a little, arms and legs near their standing pose. No rig: an error, with `why`.
Fallen make_fallen(const GaitSetup& setup, FallWay lies_on, std::uint64_t seed, std::string& why) {
  math::Random random(seed, 0x415e);
  const auto standing = Rig::create(setup, seed, why);
  if (!standing) return {};
  plant::PitchPlace start;
  start.lie = place_of(lies_on);
  start.heading_rad = random.uniform(-math::kPi, math::kPi);
  for (const double rad : standing->targets()) start.joints_rad.push_back(rad + random.uniform(-0.15, 0.15));
  return {Rig::create(setup, seed, why, start), standing->truth().torso.p_m.z};
}

}  // namespace

std::optional<TurnResult> run_turn(const GaitSetup& setup, const std::string& name, FallWay lies_on, std::uint64_t seed,
                                   std::string& why) {
  const std::vector<motion::KeyPose>* poses = setup.book.find(name);
  if (poses == nullptr) {
    why = "the motion file has no motion " + name;
    return std::nullopt;
  }
  const auto [rig, stands_m] = make_fallen(setup, lies_on, seed, why);
  if (!rig) return std::nullopt;
  const auto up = [&] { return rig->truth().torso.q.conjugate().rotate({0, 0, 1}); };
  for (double t_s = 0; t_s < kLie_s; t_s += kControl_s) {
    static_cast<void>(rig->sense());
    rig->act(rig->targets());
  }
  TurnResult out;
  out.lay = motion::lying(up()) == lies_on;
  std::vector<motion::KeyPose> unchecked = *poses;  // a search sees how far it came
  for (motion::KeyPose& pose : unchecked) {
    pose.check = motion::PoseCheck::none;
    out.lasts_s += pose.duration_s + pose.hold_s;
  }
  PosePlayer player;
  player.start(unchecked, rig->sense().joints_rad);
  for (double t_s = 0; t_s < out.lasts_s + kLie_s; t_s += kControl_s) {
    player.step(up(), kControl_s, rig->targets());
    rig->act(rig->targets());
  }
  out.up = up();
  return out;
}

std::optional<MotionResult> run_motion(const GaitSetup& setup, const std::string& name, std::uint64_t seed,
                                       std::string& why) {
  const std::vector<motion::KeyPose>* poses = setup.book.find(name);
  if (poses == nullptr) {
    why = "the motion file has no motion " + name;
    return std::nullopt;
  }
  const auto [rig, stands_m] =
      make_fallen(setup, name.find("back") != std::string::npos ? FallWay::back : FallWay::front, seed, why);
  if (!rig) return std::nullopt;
  motion::Walk walk = rig->make_walk();
  motion::Tilt tilt;
  motion::PosePlayer player;
  MotionResult out;
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
    const double up = truth.torso.q.rotate({0, 0, 1}).z;
    const double height_m = truth.torso.p_m.z;
    const double share = (truth.foot_n[0] + truth.foot_n[1]) / (rig->figure().mass_kg() * 9.81);
    const bool stands = up > kUp && height_m > 0.85 * stands_m && !truth.body_down;
    if (!stands) upright_since_s = -1;
    if (stands && upright_since_s < 0) upright_since_s = t_s;
    if (t_s >= 0) {
      const double load = std::clamp(share, 0.0, 1.0);
      const double upright = 0.5 * (1 + up);  // feet that touch each other bear nothing
      const double lacks = 1 - 0.4 * upright - 0.3 * std::clamp(height_m / stands_m, 0.0, 1.0) - 0.3 * load * upright;
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
  out.stood = upright_since_s >= 0 && upright_since_s <= most_rise_s(FallWay::front) &&
              player.state() == motion::PosePlayer::State::done;
  out.shortfall = sum / counted;
  return out;
}

std::optional<RiseResult> run_rise(const GaitSetup& setup, FallWay lies_on, std::uint64_t seed, std::string& why) {
  const auto [rig, stands_m] = make_fallen(setup, lies_on, seed, why);
  if (!rig) return std::nullopt;
  const motion::PoseMotions motions(setup.book, setup.body);
  motion::Walk walk = rig->make_walk();
  motion::Tilt tilt;
  PosePlayer player;
  RiseResult out;
  double upright_since_s = -1, rests_s = 0;
  bool walking = false;
  motion::PoseMotion plays = motion::PoseMotion::none;
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kLie_s;
    if (t_s > most_rise_s(lies_on) + kStay_s) break;
    const motion::Sensed sensed = rig->sense();
    if (tick == 0) tilt.start(sensed.accel_mps2);
    tilt.step(sensed.gyro_radps, sensed.accel_mps2, false, kControl_s);
    if (walking) {
      walk.step({}, sensed, kControl_s, rig->targets());
    } else if (player.state() == PosePlayer::State::playing) {
      player.step(tilt.up(), kControl_s, rig->targets());
      if (player.state() == PosePlayer::State::done && tilt.up().z > kUp) {
        walk.reset(sensed);
        walking = true;
      }
      rests_s = 0;
    } else if (t_s >= 0 && (out.motions == 0 || (rests_s += kControl_s) > kAgain_s)) {
      plays = motions.rise_from(motion::lying(tilt.up()), plays);
      if (const auto* poses = motions.poses(plays)) {  // without one it stays as it lies
        player.start(*poses, sensed.joints_rad);
        ++out.motions;
      }
    }
    rig->act(rig->targets());

    const plant::BodyTruth& truth = rig->truth();
    const bool stands =
        truth.torso.q.rotate({0, 0, 1}).z > kUp && truth.torso.p_m.z > 0.85 * stands_m && !truth.body_down;
    if (!stands) upright_since_s = -1;
    if (stands && upright_since_s < 0) upright_since_s = t_s;
  }
  out.stood = walking && upright_since_s >= 0 && upright_since_s <= most_rise_s(lies_on);
  out.time_s = upright_since_s;
  return out;
}

}  // namespace sinew::gait
