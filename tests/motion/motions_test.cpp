// Falls, poses, gaze, kicks from a stand, and what servos need.
#include "math/random.hpp"
#include "motion/ball_stop.hpp"
#include "motion/fall.hpp"
#include "motion/gaze.hpp"
#include "motion/kept_numbers.hpp"
#include "motion/key_poses.hpp"
#include "motion/kick.hpp"
#include "motion/posture.hpp"
#include "op3.hpp"

namespace sinew::motion {
namespace {

using math::Quat;
using math::Vec3;

TEST(FallDetector, TellsATopplingBodyBeforeItIsHalfDownAndWhichWay) {
  for (const double way : {1.0, -1.0}) {
    FallDetector detector;
    double tilt = 0.05 * way, rate = 0.8 * way, told_at = 0;
    for (int i = 0; i < 200 && told_at == 0; ++i) {
      rate += 25 * math::sin(tilt) * kStep_s;
      tilt += rate * kStep_s;
      detector.step(Quat::from_axis_angle({0, 1, 0}, tilt).conjugate().rotate({0, 0, 1}), {0, rate, 0}, kStep_s);
      if (detector.way() != FallWay::none) told_at = math::fabs(tilt);
    }
    EXPECT_EQ(detector.way(), way > 0 ? FallWay::front : FallWay::back);
    EXPECT_LT(told_at, 0.7);
  }
}

TEST(FallDetector, TellsTheSideAndStaysQuietInASway) {
  FallDetector detector;
  for (int i = 0; i < 1000; ++i) {
    const double phase = 2 * math::kPi * i * kStep_s / 0.6;
    detector.step(Quat::from_axis_angle({1, 0, 0}, 0.1 * math::sin(phase)).conjugate().rotate({0, 0, 1}),
                  {1.05 * math::cos(phase), 0, 0}, kStep_s);
  }
  EXPECT_EQ(detector.way(), FallWay::none);
  for (int i = 0; i < 10; ++i)
    detector.step(Quat::from_axis_angle({1, 0, 0}, 0.8).conjugate().rotate({0, 0, 1}), {}, kStep_s);
  EXPECT_EQ(detector.way(), FallWay::right);
}

TEST(FallDetector, JointsGiveWayLaterAndNotAtAllIfTheBodyCameBack) {
  const Vec3 toppling = Quat::from_axis_angle({1, 0, 0}, 0.8).conjugate().rotate({0, 0, 1}), upright{0, 0, 1};
  FallDetector detector({.hold_s = 0, .give_way_s = 0.08});
  detector.step(toppling, {}, kStep_s);
  EXPECT_EQ(detector.way(), FallWay::right) << "told at once";
  for (int i = 0; i < 7; ++i) detector.step(toppling, {}, kStep_s);
  EXPECT_FALSE(detector.gives_way());
  detector.step(upright, {}, kStep_s);
  EXPECT_EQ(detector.way(), FallWay::none) << "taken back";
  for (int i = 0; i < 10; ++i) detector.step(toppling, {}, kStep_s);
  EXPECT_TRUE(detector.gives_way());
  for (int i = 0; i < 10; ++i) detector.step(upright, {}, kStep_s);
  EXPECT_TRUE(detector.gives_way()) << "until reset()";
  EXPECT_EQ(detector.way(), FallWay::right);
  detector.reset();
  EXPECT_FALSE(detector.gives_way());
}

TEST(FallDetector, ABodyLiesOnlyWhenItIsStill) {
  FallDetector detector;
  for (int i = 0; i < 100; ++i) detector.step({-1, 0, 0}, {0, 2, 0}, kStep_s);
  EXPECT_FALSE(detector.lies());
  for (int i = 0; i < 100; ++i) detector.step({-1, 0, 0}, {}, kStep_s);
  EXPECT_TRUE(detector.lies());
  EXPECT_EQ(lying({-1, 0, 0}), FallWay::front);
  EXPECT_EQ(lying({1, 0, 0}), FallWay::back);
  EXPECT_EQ(lying({0, 1, 0}), FallWay::right);
  EXPECT_EQ(lying({0, 0, 1}), FallWay::none);
}

std::vector<KeyPose> two_poses() {
  std::vector<KeyPose> poses(2);
  poses[0].duration_s = 0.2;
  poses[0].rad[0] = 1;
  poses[1].duration_s = 0.3;
  poses[1].hold_s = 0.1;
  poses[1].rad[0] = -1;
  poses[1].check = PoseCheck::upright;
  return poses;
}

TEST(KeyPoses, MirroredIsTheOtherSidesMotionAndTwiceTheSame) {
  const Op3 op3;
  const auto* poses = op3.book.find("rise_back");
  ASSERT_NE(poses, nullptr);
  auto turned = *poses;
  const std::size_t pan = op3.figure->head_pan(), tilt = op3.figure->head_tilt();
  turned[0].rad[pan] = 0.3, turned[0].rad[tilt] = 0.2;
  const auto other = mirrored(turned, op3.body);
  ASSERT_EQ(other.size(), turned.size());
  const std::size_t l = op3.figure->find_joint("l_shoulder_roll"), r = op3.figure->find_joint("r_shoulder_roll");
  EXPECT_NE(turned[1].rad[l], turned[1].rad[r]) << "it pushes with one arm";
  EXPECT_EQ(other[1].rad[l], turned[1].rad[r]);
  EXPECT_EQ(other[1].rad[r], turned[1].rad[l]);
  EXPECT_EQ(other[0].rad[pan], -0.3) << "to the other side";
  EXPECT_EQ(other[0].rad[tilt], 0.2);
  EXPECT_EQ(other[2].name, turned[2].name);
  const auto back = mirrored(other, op3.body);
  for (std::size_t i = 0; i < back.size(); ++i) EXPECT_EQ(back[i].rad, turned[i].rad);
}

TEST(PosePlayer, IsInEachPoseAtItsTimeAndStaysInTheLast) {
  const auto poses = two_poses();
  PosePlayer player;
  double target[1] = {0.5};
  player.start(poses, target);
  double before = 0.5, fastest = 0;
  for (int i = 1; i <= 70; ++i) {
    player.step({0, 0, 1}, kStep_s, target);
    fastest = std::max(fastest, math::fabs(target[0] - before));
    before = target[0];
    if (i == 20) {
      EXPECT_NEAR(target[0], 1, 1e-9);
    }
    if (i == 50) {
      EXPECT_NEAR(target[0], -1, 1e-9);
    }
    EXPECT_EQ(player.state(), i < 60 ? PosePlayer::State::playing : PosePlayer::State::done) << i;
  }
  EXPECT_LT(fastest, 0.11);
  EXPECT_NEAR(target[0], -1, 1e-9);
}

TEST(PosePlayer, AMotionWhosePoseIsNotWhatItHasToBeHasFailed) {
  const auto poses = two_poses();
  PosePlayer player;
  double target[1] = {0};
  player.start(poses, target);
  for (int i = 0; i < 70; ++i) player.step({-1, 0, 0}, kStep_s, target);
  EXPECT_EQ(player.state(), PosePlayer::State::failed);
}

TEST(Gaze, ThePointIsInTheMiddleOfTheViewWhereverTheTorsoLeans) {
  const Op3 op3;
  math::Random random(5);
  kinematics::BodyPose pose(op3.body);
  for (int trial = 0; trial < 100; ++trial) {
    Gaze gaze(*op3.figure);
    const kinematics::Pose torso{
        {random.uniform(-1, 1), random.uniform(-1, 1), 0.26},
        Quat::from_yaw_pitch_roll({random.uniform(-3, 3), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)})};
    const Vec3 point = torso.of({random.uniform(0.5, 3), random.uniform(-1.5, 1.5), random.uniform(-0.2, 0.1)});
    gaze.look_at(point);
    std::vector<double> joints(op3.body.joints());
    for (int i = 0; i < 150; ++i) {
      std::vector<double> targets = joints;
      gaze.step(torso, {}, joints, kStep_s, targets);
      joints = targets;
    }
    ASSERT_FALSE(gaze.limited());
    pose.set(joints, torso);
    const kinematics::Pose camera = pose.place(*op3.body.find_place("camera"));
    const Vec3 ahead = camera.q.rotate({1, 0, 0}), to = normalized(point - camera.p_m);
    EXPECT_GT(dot(ahead, to), 0.9999) << trial;
    EXPECT_LT(gaze.error_rad(), 0.02) << trial;
  }
}

TEST(Gaze, ATurningTorsoIsLookedAheadOf) {
  const Op3 op3;
  Gaze gaze(*op3.figure);
  gaze.params.rate_smooth_s = 0;
  gaze.look_along({1, 0, 0});
  std::vector<double> joints(op3.body.joints()), targets = joints;
  double yaw = 0;
  for (int i = 0; i < 60; ++i) {
    yaw += 0.5 * kStep_s;
    gaze.step({{}, Quat::from_axis_angle({0, 0, 1}, yaw)}, {0, 0, 0.5}, joints, kStep_s, targets);
    joints = targets;
  }
  EXPECT_NEAR(targets[op3.figure->head_pan()], -(yaw + 0.5 * gaze.params.lag_s), 1e-6);
}

TEST(Kick, GoesOnFromNumbersAsIfItHadNotStopped) {
  const Op3 op3;
  Kick kick(*op3.figure, op3.book.walk, op3.book.rest_rad);
  std::vector<double> one(op3.body.joints()), two = one;
  kick.start(Side::right, KickWay::forward);
  for (int i = 0; i < 70; ++i) kick.step({}, {0.1, 0.2, 0}, kStep_s, one);
  std::vector<double> kept(count_numbers(kick));
  write_numbers(kick, kept);
  Kick again(*op3.figure, op3.book.walk, op3.book.rest_rad);
  read_numbers(again, kept);
  for (int i = 0; i < 40; ++i) {
    kick.step({}, {}, kStep_s, one);
    again.step({}, {}, kStep_s, two);
    ASSERT_EQ(one, two) << i;
  }
}

TEST(Kick, StrikesWithItsFootOverTheOtherAndEndsAsItBegan) {
  const Op3 op3;
  for (const Side foot : kSides)
    for (const KickWay way : {KickWay::forward, KickWay::outward}) {
      Kick kick(*op3.figure, op3.book.walk, op3.book.rest_rad);
      kick.forward = op3.book.kick_forward;
      kick.outward = op3.book.kick_outward;
      std::vector<double> targets(op3.body.joints()), first;
      kick.start(foot, way);
      kinematics::BodyPose pose(op3.body);
      double furthest = 0;
      const Quat lean = Quat::from_axis_angle({0, 1, 0}, op3.book.walk.lean_rad);
      while (kick.active()) {
        kick.step(lean, {}, kStep_s, targets);
        if (first.empty()) first = targets;
        pose.set(targets, {{}, lean});
        const Vec3 apart = op3.figure->sole(pose, foot).p_m - op3.figure->sole(pose, other(foot)).p_m;
        furthest = std::max(furthest, way == KickWay::forward ? apart.x : sign(foot) * apart.y);
      }
      const double reach =
          way == KickWay::forward ? kick.forward.strike_m : op3.book.walk.stance_m + kick.outward.strike_m;
      EXPECT_GT(furthest, 0.8 * reach);
      for (std::size_t j = 0; j < targets.size(); ++j) EXPECT_NEAR(targets[j], first[j], 0.02) << j;
    }
}

TEST(BallStop, PutsItsFootAsideAndEndsAsItBegan) {
  const Op3 op3;
  const double ball_m = 0.14;
  WalkParams walk = op3.book.walk;
  walk.lead_s = walk.weight_ahead = walk.play_rad = 0;  // what servos need is tested beside it
  for (const Side foot : kSides) {
    BallStop stop(*op3.figure, walk, op3.book.rest_rad);
    stop.params = op3.book.stop;
    std::vector<double> targets(op3.body.joints()), first;
    stop.start(foot);
    kinematics::BodyPose pose(op3.body);
    double widest = 0, apart_when_ready = 0;
    const Quat lean = Quat::from_axis_angle({0, 1, 0}, op3.book.walk.lean_rad);
    for (double t_s = kStep_s; stop.active(); t_s += kStep_s) {
      stop.step(lean, {}, kStep_s, targets);
      if (first.empty()) first = targets;
      pose.set(targets, {{}, lean});
      const double apart = sign(foot) * (op3.figure->sole(pose, foot).p_m - op3.figure->sole(pose, other(foot)).p_m).y;
      widest = std::max(widest, apart);
      if (t_s <= stop.ready_s()) apart_when_ready = apart;
    }
    EXPECT_NEAR(apart_when_ready, walk.stance_m + stop.params.aside_m, 1e-3);
    EXPECT_LT(widest - op3.figure->leg(foot).sole_width_m, ball_m) << "no ball gets through";
    for (std::size_t j = 0; j < targets.size(); ++j) EXPECT_NEAR(targets[j], first[j], 0.02) << j;
  }
}

TEST(BallStop, GoesOnFromNumbersAsIfItHadNotStopped) {
  const Op3 op3;
  BallStop stop(*op3.figure, op3.book.walk, op3.book.rest_rad);
  std::vector<double> one(op3.body.joints()), two = one;
  stop.start(Side::left);
  for (int i = 0; i < 90; ++i) stop.step({}, {0.1, 0.2, 0}, kStep_s, one);
  std::vector<double> kept(count_numbers(stop));
  write_numbers(stop, kept);
  BallStop again(*op3.figure, op3.book.walk, op3.book.rest_rad);
  read_numbers(again, kept);
  for (int i = 0; i < 40; ++i) {
    stop.step({}, {}, kStep_s, one);
    again.step({}, {}, kStep_s, two);
    ASSERT_EQ(one, two) << i;
  }
}

TEST(ServoLead, HoldsTheWeightThatSoftServosYieldTo) {
  const Op3 op3;
  JointAngles rad = op3.book.rest_rad;
  for (const Side side : kSides) op3.figure->place_sole(side, {{0, sign(side) * 0.04, -0.2}, {}}, rad);
  const JointAngles wanted = rad;
  const double weight_n = op3.figure->mass_kg() * 9.81;
  std::array<LegLoad, 2> loads{};
  loads[index(Side::left)] = {{0, 0, weight_n}, {0, 0.04, -0.2}};  // the whole body on the left sole
  ServoLead lead(*op3.figure);
  lead.step({.gain_per_rad = 10, .weight_ahead = 1}, loads, kStep_s, std::span(rad).first(op3.body.joints()));
  const std::size_t knee = op3.figure->find_joint("l_knee");
  // The knee carries the weight at its distance from the vertical through the sole, in front of it.
  kinematics::BodyPose pose(op3.body);
  pose.set(std::span(wanted).first(op3.body.joints()));
  const double torque_nm = weight_n * pose.link(knee + 1).p_m.x;
  EXPECT_NEAR(rad[knee] - wanted[knee], -torque_nm / (10 * 4.1), 1e-4);
  EXPECT_EQ(rad[op3.figure->find_joint("r_knee")], wanted[op3.figure->find_joint("r_knee")]);
}

TEST(MotionBook, GoesThroughTheTextOfItsFileUnchanged) {
  const Op3 op3;
  MotionBook book = op3.book;
  book.stop.aside_m = 0.0625;
  book.kick_forward.strike_m = 0.125;
  book.kick_outward.strike_m = 0.0875;
  book.gaze.lag_s = 0.0375;
  const auto read = app::parse_motions(app::motions_text(book, op3.body, "# of a test\n"), "a_motion.toml", op3.body);
  EXPECT_TRUE(read.problems.empty());
  EXPECT_EQ(read.book.stop.aside_m, 0.0625);
  EXPECT_EQ(read.book.stop.hold_s, book.stop.hold_s);
  EXPECT_EQ(read.book.kick_forward.strike_m, 0.125);
  EXPECT_EQ(read.book.kick_outward.strike_m, 0.0875);
  EXPECT_EQ(read.book.gaze.lag_s, 0.0375);
  EXPECT_EQ(read.book.poses.size(), book.poses.size());
}

TEST(Figure, ABodyWithoutSolesIsRefusedByName) {
  const Op3 op3;
  kinematics::Body body = op3.body;
  body.places.clear();
  std::string why;
  EXPECT_FALSE(Figure::make(body, why));
  EXPECT_EQ(why, "op3: it has no place l_sole");
}

}  // namespace
}  // namespace sinew::motion
