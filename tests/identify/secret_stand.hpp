#pragma once
// A humanoid on the pitch with secret zeros and soles, which stands in poses before a board on the ground.
#include "apps/toml/body_reader.hpp"
#include "identify/stand_fit.hpp"
#include "math/random.hpp"
#include "motion/sole_level.hpp"
#include "motion/stand_poses.hpp"
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::identify::test {

inline constexpr LensCamera kStandCamera{210, 210, 159.5, 119.5, {}};
inline constexpr double kBoardSquare_m = 0.04, kCorner_px = 0.12;

struct StandErrors {
  double zero_deg = 1.5, sole_tilt_deg = 0.5, sole_height_mm = 1;
  std::size_t poses = 40, later = 10;
};

struct SecretStand {
  kinematics::Body body;         // as drawn
  std::vector<double> zero_rad;  // by joint; an ankle's with its sole's tilt
  std::array<double, 2> thicker_m{};
  StandRecord record;
  /// Poses that are not in the record: what was measured, and where the camera was from the left sole.
  struct Later {
    std::vector<double> joints_rad;
    kinematics::Pose camera;
  };
  std::vector<Later> later;
  std::size_t dropped = 0;  // poses in which a sole did not lie flat
  bool fell = false;
};

inline SecretStand stand_before_board(std::uint64_t seed, const StandErrors& errors,
                                      const plant::BodyErrors& others = {}) {
  SecretStand out;
  out.body = app::load_body(sinew::test::source_dir() + "/robots/kid/op3.toml").body;
  std::string why;
  const auto figure = motion::Figure::make(out.body, why);
  motion::StandPosesOptions plan;
  plan.poses = errors.poses + errors.later, plan.seed = seed;
  const auto poses = motion::stand_poses(*figure, plan);
  plant::PitchOptions pitch_options;
  pitch_options.ground = plant::GroundErrors::none();
  pitch_options.has_ball = false;
  pitch_options.board = {kBoardSquare_m, 0.36, 0, 0, 0};
  plant::PitchBody body{.body = out.body};
  body.errors = others;
  body.errors.joint_zero_deg = errors.zero_deg;
  body.errors.sole_tilt_deg = errors.sole_tilt_deg;
  body.errors.sole_height_mm = errors.sole_height_mm;
  body.gain_per_rad = 7.9;
  const std::size_t joints = out.body.joints();
  body.start.joints_rad.assign(poses[0].begin(), poses[0].begin() + static_cast<std::ptrdiff_t>(joints));
  auto made = plant::Pitch::create(pitch_options, {&body, 1}, seed, &why);
  plant::Pitch& pitch = **made;

  out.record.body = nullptr;  // set by whoever keeps the body
  out.record.camera = kStandCamera;
  out.record.camera_place = *out.body.find_place("camera");
  const kinematics::Pose board = pitch_options.board.pose();
  math::Random random(seed, 9);
  motion::SoleLevel level(*figure);
  constexpr int kMove = 300, kHold = 450, kMean = 150, kRest = 50;  // steps of 2 ms
  for (std::size_t n = 0; n < poses.size(); ++n) {
    StandPose mean;
    mean.joints_rad.assign(joints, 0);
    bool flat = true;
    for (int step = 0; step < kMove + kHold; ++step) {
      if (step % 4 == 0) {
        const double t = std::min(1.0, static_cast<double>(step) / kMove), part = t * t * t * (10 + t * (6 * t - 15));
        std::vector<double> target(joints);
        for (std::size_t j = 0; j < joints; ++j)
          target[j] = n == 0 ? poses[0][j] : poses[n - 1][j] + part * (poses[n][j] - poses[n - 1][j]);
        if (step < kMove + kHold - kMean - kRest) level.step(pitch.sensors(0).cell_n, 0.008);
        level.add_to(target);
        pitch.command(0, target);
      }
      pitch.step();
      if (step < kMove + kHold - kMean) continue;
      const plant::BodySensors& s = pitch.sensors(0);
      for (std::size_t j = 0; j < joints; ++j) mean.joints_rad[j] += s.joint[j].position_rad / kMean;
      mean.accel_mps2 += s.accel_mps2 / kMean;
      flat = flat && (step % 50 != 0 || motion::lie_flat(s.cell_n));
    }
    out.fell = out.fell || pitch.truth(0).fallen || pitch.truth(0).body_down;
    if (!flat) {
      ++out.dropped;
      continue;
    }
    const kinematics::Pose head = pitch.truth(0).link[out.record.camera_place.link] * out.record.camera_place.pose;
    if (n >= errors.poses) {
      const kinematics::Place& sole = *pitch.body(0).find_place("l_sole");
      out.later.push_back({mean.joints_rad, (pitch.truth(0).link[sole.link] * sole.pose).inverse() * head});
      continue;
    }
    const kinematics::Pose camera{head.p_m, head.q * math::Quat{0.5, -0.5, 0.5, -0.5}};
    for (int k = 0; k < plant::kBoardColumns * plant::kBoardRows; ++k) {
      const double x = k % plant::kBoardColumns * kBoardSquare_m, y = k / plant::kBoardColumns * kBoardSquare_m;
      const auto at = kStandCamera.pixel(camera.inverse().of(board.of({x, y, 0})));
      mean.view.push_back({x, y, at.u_px + random.normal(0, kCorner_px), at.v_px + random.normal(0, kCorner_px)});
    }
    out.record.poses.push_back(std::move(mean));
  }

  for (std::size_t j = 0; j < joints; ++j) out.zero_rad.push_back(pitch.joint_zero_rad(0, j));
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string name = side == 0 ? "l" : "r";
    const kinematics::Place &drawn = *out.body.find_place(name + "_sole"),
                            &truth = *pitch.body(0).find_place(name + "_sole");
    const kinematics::Pose error = drawn.pose.inverse() * truth.pose;
    out.thicker_m[side] = -error.p_m.z;
    const math::Vec3 tilt = error.q.log();
    const std::size_t roll = *out.body.find_link(name + "_ankle_roll"),
                      pitch_link = *out.body.find_link(name + "_ankle_pitch");
    out.zero_rad[roll - 1] -= tilt.x * out.body.links[roll].axis.x;
    out.zero_rad[pitch_link - 1] -= tilt.y * out.body.links[pitch_link].axis.y;
  }
  return out;
}

}  // namespace sinew::identify::test
