#include "record/run/quantity.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "../../rt/topic_fixture.hpp"
#include "math/linear.hpp"
#include "msg/flight.hpp"

namespace sinew::record::quantity_test {
namespace {

using ::testing::ElementsAre;

const Quantity& find(const std::vector<Quantity>& all, std::string_view path) {
  return *std::find_if(all.begin(), all.end(), [&](const auto& q) { return q.path == path; });
}

msg::Quat turned(double yaw, double pitch, double roll) {
  return math::Quat::from_yaw_pitch_roll({yaw, pitch, roll}).to<msg::Quat>();
}

TEST(Quantity, EveryNumberOfAMessageIsOne) {
  std::vector<std::string> paths;
  for (const auto& q : quantities(msg::type_info<rt::Pair>())) paths.push_back(q.path);
  EXPECT_THAT(paths, ElementsAre("stamp", "number", "reserved", "value[0]", "value[1]", "value[2]", "value[3]"));
}

TEST(Quantity, AnAttitudeHasTwoAnglesAndAVectorTheUnitOfItsField) {
  const auto all = quantities(msg::type_info<msg::NavState>());
  EXPECT_EQ(find(all, "q_world_base.angle").unit, "deg");
  EXPECT_EQ(find(all, "q_world_base.tilt").what, Quantity::What::tilt);
  EXPECT_EQ(find(all, "v_world_mps.y").unit, "m/s");
}

TEST(Quantity, NumbersDifferByWhatTheSecondHasMore) {
  const auto all = quantities(msg::type_info<rt::Pair>());
  rt::Pair a, b;
  a.stamp = rt::Time{1'700'000'000'000'000'001}, b.stamp = rt::Time{1'700'000'000'000'000'004};  // beyond a double
  a.number = 5, b.number = 3;
  a.value[2] = 1.5, b.value[2] = 4;
  const auto by = [&](std::string_view path) { return difference(find(all, path), &a, find(all, path), &b); };
  EXPECT_EQ(by("stamp"), 3);
  EXPECT_EQ(by("number"), -2);
  EXPECT_EQ(by("value[2]"), 2.5);
  EXPECT_EQ(find(all, "value[2]").value(&b), 4);
}

TEST(Quantity, HeadingIsInTheAngleButNotInTheTilt) {
  const auto all = quantities(msg::type_info<msg::AttitudeSetpoint>());
  const Quantity &angle = find(all, "q_world_base.angle"), &tilt = find(all, "q_world_base.tilt");
  msg::AttitudeSetpoint a, b;
  a.q_world_base = turned(0.3, 0.2, -0.4);
  b.q_world_base = turned(0.3 + 1.0, 0.2, -0.4);
  EXPECT_NEAR(difference(angle, &a, angle, &b), 57.29578, 1e-5);
  EXPECT_NEAR(difference(tilt, &a, tilt, &b), 0, 1e-9);
  a.q_world_base = turned(0.7, 0, 0.1), b.q_world_base = turned(0.7, 0, 0.35);
  EXPECT_NEAR(difference(angle, &a, angle, &b), 0.25 * 57.29578, 1e-5);
  EXPECT_NEAR(difference(tilt, &a, tilt, &b), 0.25 * 57.29578, 1e-5);
  b.q_world_base = {-a.q_world_base.w, -a.q_world_base.x, -a.q_world_base.y, -a.q_world_base.z};
  EXPECT_NEAR(difference(angle, &a, angle, &b), 0, 1e-6) << "it is the same attitude";
}

TEST(Quantity, ANameMayBeGivenInPart) {
  const char* const name = "filter.state.q_world_base.tilt";
  for (const char* good : {"filter", "filter.state", "state.q_world_base", "tilt", name})
    EXPECT_TRUE(means(good, name)) << good;
  for (const char* bad : {"", "filt", "state.tilt", "ilt", "world", "filter.state.q_world_base.tilt.x"})
    EXPECT_FALSE(means(bad, name)) << bad;
  EXPECT_TRUE(means("value", "mixer.motors.value[3]"));
  EXPECT_TRUE(means("value[3]", "mixer.motors.value[3]"));
  EXPECT_FALSE(means("value[3]", "mixer.motors.value[31]"));
}

TEST(Quantity, BetweenTwoMessagesNumbersLieOnALineAndAttitudesOnTheShorterWay) {
  msg::NavState a, b, between;
  a.p_world_m = {1, 2, 3}, b.p_world_m = {3, 2, -1};
  a.q_world_base = turned(0.1, 0, 0), b.q_world_base = turned(0.5, 0, 0);
  b.q_world_base = {-b.q_world_base.w, -b.q_world_base.x, -b.q_world_base.y, -b.q_world_base.z};
  a.gyro_bias_radps.x = NAN;
  a.pad_known = 7, b.pad_known = 9;
  interpolate(msg::type_info<msg::NavState>(), &a, &b, 0.5, &between);
  EXPECT_EQ(between.p_world_m, (msg::Vec3{2, 2, 1}));
  EXPECT_NEAR(math::angle_between(math::Quat(between.q_world_base), math::Quat(turned(0.3, 0, 0))), 0, 1e-9);
  EXPECT_TRUE(std::isnan(between.gyro_bias_radps.x));
  EXPECT_EQ(between.pad_known, 7u);
  a.q_world_base = {NAN, NAN, NAN, NAN};
  interpolate(msg::type_info<msg::NavState>(), &a, &b, 0.5, &between);
  EXPECT_TRUE(std::isnan(between.q_world_base.w)) << "what is not known does not become an attitude";
}

}  // namespace
}  // namespace sinew::record::quantity_test
