// Each invariant accepts right data, and is named for wrong data.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "apps/search/command_check.hpp"
#include "apps/search/flight_check.hpp"

namespace sinew::search::check_test {
namespace {

using namespace std::chrono_literals;

Time ms(double t) { return Time{static_cast<std::int64_t>(t * 1e6)}; }

class CommandCheckTest : public ::testing::Test {
 protected:
  static rt::ActuatorSpec spec() {
    rt::ActuatorSpec a;
    a.name = "motors";
    a.channels = 2;
    a.max = 1;
    a.lease = 20ms;
    return a;
  }
  static msg::ActuatorCommand command(Time stamp) {
    msg::ActuatorCommand c;
    c.stamp = stamp;
    c.count = 2;
    c.armed = 1;
    c.value[0] = c.value[1] = 0.5;
    return c;
  }
  std::string failed() const { return verdict.first() ? verdict.first()->invariant : ""; }
  Verdict verdict;
  CommandCheck check{spec(), 10ms, verdict};
};

TEST_F(CommandCheckTest, ACommandWithWhatIsLeftOfItsLeaseIsRight) {
  check.committed(ms(100), ms(100.5));
  check.written(ms(100.6), command(ms(98)), 19900us);
  EXPECT_EQ(failed(), "");
  EXPECT_EQ(check.valid_until(), ms(120.5));
  check.written(ms(110), command(ms(98)), 10500us);
  EXPECT_EQ(failed(), "");
  check.stopped(ms(111));
  EXPECT_EQ(check.valid_until(), ms(111));
}

TEST_F(CommandCheckTest, AFullLeaseForAnOldCommandIsNot) {
  check.committed(ms(100), ms(100.5));
  check.written(ms(100.6), command(ms(98)), 20ms);
  EXPECT_EQ(failed(), "lease");
}

TEST_F(CommandCheckTest, AFreshCommandOnAnOldMeasurementIsNot) {
  check.committed(ms(100), ms(100.5));
  check.written(ms(100.6), command(ms(89.9)), 19900us);
  EXPECT_EQ(failed(), "lease");
}

TEST_F(CommandCheckTest, AMeasurementThatNobodyMadeIsNot) {
  check.committed(ms(100), ms(100.5));
  check.measured(ms(98));
  check.written(ms(100.6), command(ms(98)), 19900us);
  EXPECT_EQ(failed(), "");
  check.written(ms(100.7), command(ms(99)), 19800us);
  EXPECT_EQ(failed(), "stamp");
}

TEST_F(CommandCheckTest, ValuesAreFiniteInsideTheirLimitsAndOnePerChannel) {
  for (const double wrong : {-0.001, 1.001, std::nan(""), std::numeric_limits<double>::infinity()}) {
    Verdict v;
    CommandCheck c(spec(), 10ms, v);
    c.committed(ms(1), ms(1));
    auto bad = command(ms(1));
    bad.value[1] = wrong;
    c.written(ms(1), bad, 20ms);
    ASSERT_TRUE(v.failed()) << wrong;
    EXPECT_EQ(v.first()->invariant, "command");
  }
  check.committed(ms(1), ms(1));
  auto three = command(ms(1));
  three.count = 3;
  check.written(ms(1), three, 20ms);
  EXPECT_EQ(failed(), "command");
}

class FlightCheckTest : public ::testing::Test {
 protected:
  /// Airborne at `t`, level, with a vertical speed.
  static sim_hil::Truth at(double z_m, double vz_mps = 0, double roll_rad = 0) {
    sim_hil::Truth t;
    t.p_world_m = {0, 0, z_m};
    t.v_world_mps = {0, 0, vz_mps};
    t.q_world_base = {std::cos(roll_rad / 2), std::sin(roll_rad / 2), 0, 0};
    return t;
  }
  static Case parsed(std::string_view text) {
    std::string why;
    return parse_case(text, why).value();
  }
  std::string failed() const { return verdict.first() ? verdict.first()->invariant : ""; }
  static constexpr Time kForever{INT64_MAX / 2};
  Limits limits;
  Verdict verdict;
};

TEST_F(FlightCheckTest, LeaningTooFarInTheAirFails) {
  const Case calm;
  FlightCheck check(calm, excuses(calm, {}), limits, verdict);
  check.truth(ms(10), at(1, 0, 0.5), kForever);
  EXPECT_EQ(failed(), "");
  EXPECT_NEAR(check.worst().tilt_rad, 0.5, 1e-9);
  check.truth(ms(20), at(1, 0, 0.9), kForever);
  EXPECT_EQ(failed(), "tilt");
}

TEST_F(FlightCheckTest, OnTheGroundItMayStandAskew) {
  const Case calm;
  FlightCheck check(calm, excuses(calm, {}), limits, verdict);
  auto truth = at(0.12, 0, 0.9);
  truth.contact = 1;
  check.truth(ms(10), truth, kForever);
  EXPECT_EQ(failed(), "");
}

TEST_F(FlightCheckTest, AFailsafeInTheAirNeedsAnExcuse) {
  const Case calm, gap = parsed("fault=imu:off@0.001+0.1");
  FlightCheck excused(gap, excuses(gap, {}), limits, verdict);
  excused.guardian(ms(30), msg::kFaultLease);
  excused.truth(ms(30), at(1), ms(20));
  excused.truth(ms(40), at(1, -0.1, 1.5), ms(20));
  EXPECT_EQ(failed(), "");
  EXPECT_TRUE(excused.fell());
  FlightCheck check(calm, excuses(calm, {}), limits, verdict);
  check.guardian(ms(30), msg::kFaultLease);
  EXPECT_EQ(failed(), "failsafe");
}

TEST_F(FlightCheckTest, WithoutACommandItFalls) {
  const Case gap = parsed("fault=imu:off@0.001+0.1");
  FlightCheck falls(gap, excuses(gap, {}), limits, verdict), hovers(gap, excuses(gap, {}), limits, verdict);
  for (int t = 0; t <= 500; t += 10) falls.truth(ms(t), at(2, t < 20 ? 0 : -0.00981 * (t - 20)), ms(20));
  EXPECT_EQ(failed(), "");
  for (int t = 0; t <= 500; t += 10) hovers.truth(ms(t), at(2, 0), ms(20));
  EXPECT_EQ(failed(), "thrust");
}

TEST_F(FlightCheckTest, AValidEstimateIsTrueUnlessAFaultDisturbsIt) {
  const Case calm, stuck = parsed("fault=range:stuck@0.001+0.1");
  msg::NavState state;
  state.stamp = ms(9);
  state.q_world_base = {std::cos(0.1), std::sin(0.1), 0, 0};
  state.height_m = 1;
  FlightCheck invalid(calm, excuses(calm, {}), limits, verdict), disturbed(stuck, excuses(stuck, {}), limits, verdict),
      wrong(calm, excuses(calm, {}), limits, verdict);
  for (FlightCheck* check : {&invalid, &disturbed, &wrong}) check->truth(ms(10), at(1), kForever);
  invalid.estimate(state);
  state.attitude_valid = 1;
  disturbed.estimate(state);
  EXPECT_EQ(failed(), "");
  wrong.estimate(state);
  EXPECT_EQ(failed(), "estimate");
}

TEST_F(FlightCheckTest, AHeightThatIsOffFails) {
  const Case calm;
  FlightCheck check(calm, excuses(calm, {}), limits, verdict);
  check.truth(ms(10), at(1), kForever);
  msg::NavState state;
  state.stamp = ms(9);
  state.q_world_base = {1, 0, 0, 0};
  state.height_valid = 1;
  state.height_m = 1.2;
  check.estimate(state);
  EXPECT_EQ(failed(), "");
  state.height_m = 1.4;
  check.estimate(state);
  EXPECT_EQ(failed(), "estimate");
}

}  // namespace
}  // namespace sinew::search::check_test
