// Servos whose numbers the fit does not know.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "secret_servo.hpp"

namespace sinew::identify::servo_fit_test {
namespace {

using test::record_of;
using test::SecretServo;

constexpr control::ExcitationRange kRange{0, 0.8, 4, 40};

control::ExcitationPlan short_plan(std::uint64_t seed) {
  control::ExcitationPlan plan;
  plan.rounds = 5;
  plan.seed = seed;
  return plan;
}

ServoFitOptions quick(bool at_motor) {
  ServoFitOptions options;
  options.parts = 4;
  options.step_s = 4e-4;
  options.encoder_at_motor = at_motor;
  return options;
}

double off(const ServoFit& fit, const SecretServo& servo, ServoParameter p) {
  return math::fabs(fit.of(p).value - servo.truth(p));
}

TEST(ServoModel, OfALinkThatHangsFreeSwingsAsAPendulum) {
  ServoModel m;
  m.inertia_kgm2 = 0.02, m.gravity_sin_nm = -0.5;
  m.coulomb_nm = 0, m.viscous_nms = 0, m.rotor_kgm2 = 0.005;
  std::vector<double> time(2000), q(2000), nm(2000);
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = 1e-3 * static_cast<double>(i);
  m.run({{0}, {math::kNan}}, {.first_rad = 0.05}, time, q, nm);
  // Small swings: w = sqrt(0.5 / 0.02) = 5 rad/s.
  for (std::size_t i = 0; i < time.size(); i += 50) EXPECT_NEAR(q[i], 0.05 * math::cos(5 * time[i]), 2e-4);
}

TEST(ServoModel, RunsAtItsSpeedWithoutLoadAndHoldsItsStallTorque) {
  ServoModel m{.delay_s = 0.02, .stall_nm = 3, .no_load_radps = 6};
  m.coulomb_nm = 0, m.viscous_nms = 0;
  const std::vector<double> time{0.019, 0.5, 0.6};
  std::vector<double> q(3), nm(3);
  m.run({{0}, {100}}, {}, time, q, nm);
  EXPECT_EQ(q[0], 0);  // the command has not arrived
  EXPECT_NEAR((q[2] - q[1]) / 0.1, 6, 1e-3);
  m.gravity_cos_nm = -3.1;
  m.inertia_kgm2 = 1000;  // does not move in the time
  m.run({{0}, {100}}, {}, time, q, nm);
  EXPECT_NEAR(nm[1], 3, 0.01);
}

TEST(ServoModel, RunsInAnyStepsToTheSamePlace) {
  const SecretServo s = test::draw_servo(4);
  ServoModel m;
  for (std::size_t i = 0; i < kServoParameters; ++i)
    m.*servo_parameters()[i].value = s.truth(static_cast<ServoParameter>(i));
  const ServoRecord r = record_of(s, short_plan(4), kRange, 4);
  std::vector<double> coarse(r.time_s.size()), fine = coarse, nm = coarse;
  m.run(r.commands, {.step_s = 2.5e-4}, r.time_s, coarse, nm);
  m.run(r.commands, {.step_s = 5e-5}, r.time_s, fine, nm);
  double square = 0;
  for (std::size_t i = 0; i < fine.size(); ++i) square += (coarse[i] - fine[i]) * (coarse[i] - fine[i]);
  EXPECT_LT(math::sqrt(square / static_cast<double>(fine.size())), 3e-4);
}

TEST(ServoFit, FindsTheNumbersOfAServoThatIsNotItsModel) {
  const SecretServo s = test::draw_servo(2);
  const ServoFit fit = fit_servo(record_of(s, short_plan(2), kRange, 2), quick(s.encoder_at_motor));
  ASSERT_EQ(fit.problem, "");
  EXPECT_LT(off(fit, s, ServoParameter::delay), 0.5e-3);
  EXPECT_LT(off(fit, s, ServoParameter::coulomb), 0.1 * s.coulomb_nm);
  EXPECT_LT(off(fit, s, ServoParameter::play), 0.05 * math::kPi / 180);
  EXPECT_LT(off(fit, s, ServoParameter::stall), 0.03 * s.stall_nm);
  EXPECT_LT(off(fit, s, ServoParameter::no_load), 0.03 * s.no_load_radps);
  EXPECT_LT(off(fit, s, ServoParameter::gain), 0.03 * s.gain_per_rad);
  EXPECT_LT(off(fit, s, ServoParameter::inertia), 0.05 * s.truth(ServoParameter::inertia));
  EXPECT_LT(off(fit, s, ServoParameter::gravity_sin), 0.03 * s.gravity_nm);
  EXPECT_LT(off(fit, s, ServoParameter::gravity_cos), 0.03 * s.gravity_nm);
  // The part held out is predicted as well as the encoder's steps let it be.
  EXPECT_LT(fit.held_out.position_rad, s.encoder_step_rad / 2);
  EXPECT_GT(fit.moved.position_rad, 0.1);
  for (const ServoParameter p : {ServoParameter::delay, ServoParameter::coulomb, ServoParameter::play})
    EXPECT_TRUE(fit.of(p).half_width > 0 && fit.of(p).half_width < math::kInf);
}

TEST(ServoFit, StartsAgainFromElsewhereWhenItIsStuck) {
  // Of 100 it is the one whose first fit is the worst: delay off by 7 ms, stall torque by 18 %.
  const SecretServo s = test::draw_servo(115);
  control::ExcitationPlan plan;
  plan.seed = 115;
  ServoFitOptions options;
  options.encoder_at_motor = s.encoder_at_motor;
  options.parts = 0;
  const ServoFit fit = fit_servo(record_of(s, plan, kRange, 115), options);
  EXPECT_FALSE(fit.doubtful);
  EXPECT_LT(math::fabs(fit.model.delay_s - s.delay_s), 0.5e-3);
  EXPECT_LT(math::fabs(fit.model.stall_nm - s.stall_nm), 0.05 * s.stall_nm);
}

TEST(ServoFit, SaysThatItDoesNotExplainWhatItsModelLacks) {
  const SecretServo s = test::draw_servo(2);
  ServoRecord r = record_of(s, short_plan(2), kRange, 2);
  for (double& q : r.position_rad)  // a gear that is not round
    q = s.encoder_step_rad * math::round((q + 0.01 * math::sin(7 * q)) / s.encoder_step_rad);
  ServoFitOptions options = quick(s.encoder_at_motor);
  options.parts = 0;
  const ServoFit fit = fit_servo(r, options);
  EXPECT_TRUE(fit.doubtful);
  const std::string words = std::accumulate(fit.unknown.begin(), fit.unknown.end(), std::string());
  EXPECT_NE(words.find("whether the fit is stuck or the model lacks something"), std::string::npos) << words;
}

TEST(ServoFit, TellsTheEncodersSideOrThatBothFitEquallyWell) {
  for (const bool plays : {true, false}) {
    SecretServo s = test::draw_servo(2);
    if (!plays) s.play_rad = 1e-5;
    ServoFitOptions options = quick(false);
    options.parts = 0;
    options.encoder_at_motor.reset();
    const ServoFit fit = fit_servo(record_of(s, short_plan(2), kRange, 2), options);
    EXPECT_EQ(fit.side_known, plays);
    EXPECT_FALSE(fit.doubtful);
    if (plays) {
      EXPECT_EQ(fit.model.encoder_at_motor, s.encoder_at_motor);
    }
  }
}

TEST(ServoFit, NamesWhatARecordWithoutEffortsDoesNotShow) {
  SecretServo s = test::draw_servo(2);
  s.measures_effort = false;
  ServoFitOptions options = quick(s.encoder_at_motor);
  options.typical_stall_nm = s.stall_nm;
  const ServoFit fit = fit_servo(record_of(s, short_plan(2), kRange, 2), options);
  ASSERT_EQ(fit.problem, "");
  const std::string words = std::accumulate(fit.unknown.begin(), fit.unknown.end(), std::string());
  EXPECT_NE(words.find("the size of all torques"), std::string::npos) << words;
  EXPECT_EQ(fit.of(ServoParameter::stall).state, ServoEstimate::State::known);
  EXPECT_LT(off(fit, s, ServoParameter::delay), 1e-3);
}

TEST(ServoFit, RefusesARecordThatShowsNothing) {
  ServoRecord r;
  EXPECT_NE(fit_servo(r).problem, "");
  for (int i = 0; i < 1000; ++i) r.time_s.push_back(0.01 * i), r.position_rad.push_back(0.1);
  r.commands = {{0}, {0.1}};
  EXPECT_EQ(fit_servo(r).problem, "the joint moved by less than 0.02 rad");
  r.commands = {};
  EXPECT_EQ(fit_servo(r).problem, "no commands");
  r.effort_nm = {1, 2};
  EXPECT_EQ(fit_servo(r).problem, "times and values are not as many");
}

}  // namespace
}  // namespace sinew::identify::servo_fit_test
