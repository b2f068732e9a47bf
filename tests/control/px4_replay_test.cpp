// A flight recorded in PX4's simulator, beside what PX4's EKF2 made of it: folder px4 beside the one that SINEW_DATA
// names, or the folder itself.
#include <gmock/gmock.h>

#include <cstdlib>

#include "px4_replay.hpp"

namespace sinew::control::px4_replay_test {
namespace {

using test::Px4Flight;
using test::Replay;

constexpr double kDelay_s = 0.1;  // of the fixes: the one that fits best of 0, 0.1 and 0.2

std::optional<Px4Flight> load() {
  const char* folder = std::getenv("SINEW_DATA");
  if (!folder) return std::nullopt;
  auto flight = test::read_px4_flight(folder);
  return flight ? flight : test::read_px4_flight(std::filesystem::path(folder).parent_path() / "px4");
}

class Px4Replay : public ::testing::Test {
 protected:
  void SetUp() override {
    flight_ = load();
    if (!flight_) GTEST_SKIP() << "SINEW_DATA names no folder with ekf_gsf_reset.csv, nor one beside px4/";
  }
  std::optional<Px4Flight> flight_;
};

double angle_deg(double rad) { return math::fabs(math::wrap_pi(rad)) * 180 / math::kPi; }

TEST_F(Px4Replay, IsNoFartherFromTheNextFixThanEkf2) {
  const Replay r = test::replay(*flight_, {.gnss_delay_s = kDelay_s, .change = {}});
  const test::Innovations ours = test::innovations_of(r, 23);
  const test::Innovations ekf2 = test::best_ekf2_innovations(*flight_, r.frame, 23);
  std::cout << "next fix, RMS from lift-off: ours " << ours.v_mps << " m/s " << ours.p_m << " m, EKF2 " << ekf2.v_mps
            << " m/s " << ekf2.p_m << " m (" << ours.fixes << " fixes)\n";
  EXPECT_GT(ours.fixes, 35);
  EXPECT_LE(ours.v_mps, ekf2.v_mps);
  EXPECT_LE(ours.p_m, ekf2.p_m);
}

TEST_F(Px4Replay, AgreesWithEkf2InAttitudeAndVelocityOnceItsHeadingIsKnown) {
  const Replay r = test::replay(*flight_, {.gnss_delay_s = kDelay_s, .change = {}});
  double heading = 0, tilt = 0, speed = 0;
  for (const test::ReplayLine& l : r.lines) {
    if (l.us < 6'000'000 || l.us > 35'500'000 || (l.us > 33'000'000 && l.us < 34'600'000))
      continue;  // it turns with 195 degrees a second; standing, EKF2 still moves
    const auto e = test::ekf2_at(*flight_, l.us + 100'000);
    if (!e) continue;
    const math::Quat q = test::q_world_base(*e);
    const math::YawPitchRoll a = l.state.q_world_base.yaw_pitch_roll(), b = q.yaw_pitch_roll();
    heading = std::max(heading, angle_deg(a.yaw - b.yaw));
    tilt = std::max({tilt, angle_deg(a.pitch - b.pitch), angle_deg(a.roll - b.roll)});
    const math::Vec3 v = l.state.v_world_mps - test::enu(&e->state[4]);
    speed = std::max(speed, math::hypot(v.x, v.y));
  }
  std::cout << "largest difference from EKF2: heading " << heading << " deg, tilt " << tilt << " deg, velocity "
            << speed << " m/s\n";
  EXPECT_LT(heading, 6);
  EXPECT_LT(tilt, 5);
  EXPECT_LT(speed, 1.2);
}

TEST_F(Px4Replay, WithoutMagnetometerTheHeadingComesFromTheFirstMetresOfFlight) {
  const Replay r = test::replay(*flight_, {.mag = false, .gnss_delay_s = kDelay_s, .change = {}});
  ASSERT_FALSE(r.resets.empty());
  EXPECT_EQ(r.resets[0].reset_cause, msg::NavResetCause::first_heading);
  EXPECT_GT(r.resets[0].stamp.ns, 22'000'000'000) << "standing, nothing is known";
  EXPECT_LT(r.resets[0].stamp.ns, 29'000'000'000);
  double worst = 0;
  for (const test::ReplayLine& l : r.lines) {
    const auto e = test::ekf2_at(*flight_, l.us + 100'000);
    if (!e || !l.heading_valid || (l.us > 33'000'000 && l.us < 34'600'000)) continue;
    worst = std::max(worst, angle_deg(l.state.q_world_base.yaw() - test::q_world_base(*e).yaw()));
  }
  EXPECT_LT(worst, 20);
}

TEST_F(Px4Replay, MagnetometerTurnedBy90DegreesInFlightMovesTheHeadingByLessThan20Degrees) {
  const Replay plain = test::replay(*flight_, {.gnss_delay_s = kDelay_s, .change = {}});
  const Replay turned = test::replay(*flight_, {.gnss_delay_s = kDelay_s, .change = [](test::Px4Sample& s) {
                                                  if (s.type != "mag" || s.us < 25'000'000) return;
                                                  const double x = s.values[0];
                                                  s.values[0] = -s.values[1];
                                                  s.values[1] = x;
                                                }});
  ASSERT_EQ(plain.lines.size(), turned.lines.size());
  double worst = 0;
  for (std::size_t i = 0; i < plain.lines.size(); ++i) {
    if (plain.lines[i].us < 25'000'000) continue;
    worst =
        std::max(worst, angle_deg(plain.lines[i].state.q_world_base.yaw() - turned.lines[i].state.q_world_base.yaw()));
  }
  std::cout << "magnetometer turned at 25 s: heading off by " << worst << " deg at most\n";
  EXPECT_LT(worst, 20);
  EXPECT_GT(turned.last.source[std::size_t(msg::NavSource::mag)].rejected, 500U);
}

}  // namespace
}  // namespace sinew::control::px4_replay_test
