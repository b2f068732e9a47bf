#include "soccer/world/locator.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstring>

#include "apps/locate/study.hpp"

namespace sinew::soccer::locator_test {
namespace {

using locate::FieldWalk;

msg::FieldPose pose_of(const Locator& locator) {
  msg::FieldPose pose;
  locator.fill(pose);
  return pose;
}
FieldAt at(const msg::FieldPose& p) { return {p.x_m, p.y_m, p.heading_rad}; }

locate::StudyOptions few(std::uint64_t runs) {
  locate::StudyOptions o;
  o.first_seed = 9001;  // beside those that it was built with
  o.runs = runs;
  return o;
}

TEST(Locator, AWalkingRobotKnowsWhereItIs) {
  const locate::PoseErrors e = locate::study_walks(few(8));
  std::vector<double> m = e.off_m, rad = e.off_rad;
  std::ranges::sort(m), std::ranges::sort(rad);
  ASSERT_GT(m.size(), 7000U);
  EXPECT_LT(m[m.size() / 2], 0.10) << text(e);
  EXPECT_LT(m[m.size() * 95 / 100], 0.30) << text(e);
  EXPECT_LT(rad[rad.size() / 2] * 180 / math::kPi, 3) << text(e);
  EXPECT_LT(rad[rad.size() * 95 / 100] * 180 / math::kPi, 8) << text(e);
  EXPECT_EQ(e.wrong_half, 0U) << text(e);
  EXPECT_LT(static_cast<double>(e.lost), 0.05 * static_cast<double>(e.poses)) << text(e);
}

TEST(Locator, ARobotThatIsCarriedAwayFindsItselfAndAMatesBallTellsTheHalf) {
  const locate::Kidnappings k = locate::study_kidnappings(few(20), false);
  EXPECT_GE(std::ranges::count_if(k.found_s, [](double s) { return s <= 10; }), 18);
  EXPECT_GE(std::ranges::count_if(k.right_half_s, [](double s) { return s <= 20; }), 18);
}

TEST(Locator, ARobotThatComesBackAfterAPenaltyKnowsItsHalf) {
  const locate::Kidnappings k = locate::study_kidnappings(few(20), true);
  EXPECT_GE(std::ranges::count_if(k.right_half_s, [](double s) { return s <= 10; }), 19);
}

TEST(Locator, WithoutARuleBothHalvesAreAsProbable) {
  const Field field;
  FieldWalk walk(field, 3);
  Locator locator(field);
  locator.forget(false);
  while (pose_of(locator).found == 0 && walk.now_s() < 20) locator.see(walk.step(), true);
  ASSERT_EQ(pose_of(locator).found, 1U);
  EXPECT_EQ(pose_of(locator).mirrored, 0.5);
  locator.weigh_halves(2);
  EXPECT_LT(pose_of(locator).mirrored, 0.2);
  const FieldAt one = at(pose_of(locator));
  locator.weigh_halves(-6);
  EXPECT_LT(pose_of(locator).mirrored, 0.2) << "the other half is published now";
  EXPECT_LT(distance_m(at(pose_of(locator)), one.mirrored()), 1e-9);
}

TEST(Locator, NothingToSeeMakesItLessSureAndKeepsThePlace) {
  const Field field;
  FieldWalk walk(field, 4);
  Locator locator(field);
  locator.forget(true);
  while (walk.now_s() < 15) locator.see(walk.step(), true);
  const double before = pose_of(locator).covariance[0];
  msg::SoccerSight blind;
  for (int i = 1; i <= 40; ++i) {
    const msg::SoccerSight& seen = walk.step();
    blind.stamp = seen.stamp, blind.x_m = seen.x_m, blind.y_m = seen.y_m, blind.heading_rad = seen.heading_rad;
    locator.see(blind, true);
  }
  EXPECT_GT(pose_of(locator).covariance[0], before);
  const FieldAt believed = at(pose_of(locator)), other = believed.mirrored();
  EXPECT_LT(std::min(distance_m(believed, walk.truth()), distance_m(other, walk.truth())), 0.3);
}

TEST(Locator, TheSameSightingsGiveTheSameBytes) {
  const Field field;
  const auto run = [&] {
    FieldWalk walk(field, 5);
    Locator locator(field);
    locator.forget(true);
    while (walk.now_s() < 6) locator.see(walk.step(), true);
    return locator.state();
  };
  const Locator::State a = run(), b = run();
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

TEST(Locator, SightingsThatAreNoNumbersDoNotSpoilIt) {
  const Field field;
  FieldWalk walk(field, 6);
  Locator locator(field);
  locator.forget(true);
  while (walk.now_s() < 10) locator.see(walk.step(), true);
  msg::SoccerSight broken = walk.step();
  broken.lines = 3, broken.marks = 2, broken.posts = 99;
  broken.line[0].from.x_m = math::kNanF;
  broken.line[1].to.yy_m2 = math::kNanF;
  broken.line[2] = {};
  broken.mark[0].at = {math::kNanF, 0, 1, 0, 1};
  broken.mark[1].at = {1e30F, 1e30F, 1, 0, 1};
  for (int i = 0; i < 20; ++i) locator.see(broken, true);
  while (walk.now_s() < 14) locator.see(walk.step(), true);
  const msg::FieldPose pose = pose_of(locator);
  EXPECT_TRUE(math::is_finite(pose.x_m) && math::is_finite(pose.covariance[0]));
  EXPECT_LT(std::min(distance_m(at(pose), walk.truth()), distance_m(at(pose).mirrored(), walk.truth())), 0.3);
}

}  // namespace
}  // namespace sinew::soccer::locator_test
