// Zeros of joints that the fit does not know, of a body whose soles lie perfectly flat.
#include "identify/stand_fit.hpp"

#include <gtest/gtest.h>

#include "apps/toml/body_reader.hpp"
#include "math/random.hpp"
#include "motion/stand_poses.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::identify::stand_fit_test {
namespace {

constexpr double kRad = math::kPi / 180, kSquare = 0.04;
constexpr LensCamera kCamera{210, 210, 159.5, 119.5, {}};

struct Stand {
  kinematics::Body body = app::load_body(sinew::test::source_dir() + "/robots/kid/op3.toml").body;
  std::vector<double> zero_rad;
  StandRecord record;

  explicit Stand(std::uint64_t seed, double zero_deg = 2, std::size_t poses = 30) {
    math::Random random(seed, 4);
    std::string why;
    const auto figure = motion::Figure::make(body, why);
    for (std::size_t j = 0; j < body.joints(); ++j) zero_rad.push_back(random.normal(0, zero_deg * kRad));
    record.body = &body;
    record.camera = kCamera;
    record.camera_place = *body.find_place("camera");
    // The board's frame in the world: right of who looks along x, towards him, down.
    const kinematics::Pose board{{0.6, 0.16, 0}, math::Quat::from_matrix({0, -1, 0, -1, 0, 0, 0, 0, -1})};
    kinematics::BodyPose pose(body);
    for (const motion::JointAngles& rad : motion::stand_poses(*figure, {.poses = poses, .seed = seed})) {
      const std::span joints(rad.data(), body.joints());
      pose.set(joints);
      const kinematics::Pose sole = pose.place(*body.find_place("l_sole"));
      pose.set(joints, kinematics::Pose{{0, 0.0525, 0}, {}} * sole.inverse());
      const kinematics::Pose camera = pose.place(record.camera_place) * kinematics::Pose{{}, {0.5, -0.5, 0.5, -0.5}};
      StandPose p;
      for (std::size_t j = 0; j < body.joints(); ++j)
        p.joints_rad.push_back(rad[j] + zero_rad[j] + random.normal(0, 5e-4));
      for (int k = 0; k < 54; ++k) {
        const double x = k % 9 * kSquare, y = k / 9 * kSquare;
        const auto at = kCamera.pixel(camera.inverse().of(board.of({x, y, 0})));
        p.view.push_back({x, y, at.u_px + random.normal(0, 0.12), at.v_px + random.normal(0, 0.12)});
      }
      p.accel_mps2 = pose.place(*body.find_place("imu")).q.conjugate().rotate({0.1, 0, 9.81});
      record.poses.push_back(std::move(p));
    }
  }
};

TEST(StandFit, FindsZerosWithinIntervalsThatHold) {
  int held = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Stand s(seed);
    const StandFit fit = fit_stand(s.record);
    ASSERT_EQ(fit.problem, "");
    ASSERT_EQ(fit.estimates.size(), 16u) << "two of the head, six of each leg, two soles";
    for (std::size_t i = 0; i < 14; ++i, ++all) {
      const StandEstimate& e = fit.estimates[i];
      const double truth = s.zero_rad[*s.body.find_link(e.name) - 1];
      held += math::fabs(e.value - truth) <= e.half_width ? 1 : 0;
      EXPECT_LT(math::fabs(e.value - truth), 1.2 * kRad) << e.name;
    }
    EXPECT_LT(fit.after_rad, 0.15 * fit.before_rad);
  }
  EXPECT_GE(held * 100, 89 * all);
}

TEST(StandFit, TakesItsZerosOff) {
  const Stand s(5);
  const StandFit fit = fit_stand(s.record);
  const std::vector<double> rad = corrected(fit, s.body, s.record.poses[0].joints_rad);
  EXPECT_EQ(rad.size(), s.body.joints());
  const std::size_t tilt = *s.body.find_link("head_tilt") - 1, elbow = *s.body.find_link("l_elbow") - 1;
  EXPECT_NEAR(rad[tilt], s.record.poses[0].joints_rad[tilt] - s.zero_rad[tilt], 0.3 * kRad);
  EXPECT_EQ(rad[elbow], s.record.poses[0].joints_rad[elbow]) << "nothing is known of arms";
}

TEST(StandFit, NamesWhatHardlyDifferentPosesDoNotShow) {
  Stand s(6);
  for (std::size_t i = 1; i < s.record.poses.size(); ++i) s.record.poses[i] = s.record.poses[0];
  const StandFit fit = fit_stand(s.record);
  ASSERT_EQ(fit.problem, "");
  EXPECT_GT(fit.unknown.size(), 8u);
}

TEST(StandFit, SaysWhatIsMissing) {
  Stand s(7, 1, 11);
  EXPECT_EQ(fit_stand(s.record).problem, "only 11 poses, at least 26 are needed");
  EXPECT_EQ(fit_stand({}).problem, "no body is given");
  Stand more(8, 1, 26);
  more.record.poses[3].view.resize(3);
  EXPECT_EQ(fit_stand(more.record).problem, "pose 3 does not show where the board is");
  more.record.poses[3] = more.record.poses[4];
  more.body.places.clear();
  EXPECT_EQ(fit_stand(more.record).problem, "the body has no places l_sole and r_sole");
}

}  // namespace
}  // namespace sinew::identify::stand_fit_test
