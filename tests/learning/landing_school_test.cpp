// Learning to land without pictures: the flights, and what is learned from them.
#include "apps/learn/landing_school.hpp"

#include <gtest/gtest.h>

#include "apps/learn/study.hpp"

namespace sinew::learning::landing_school_test {
namespace {

/// Flies to above the pad and sinks there; by hand.
control::LandingWish by_hand(const control::LandingView& view) {
  control::LandingWish wish;
  for (std::size_t i = 0; i < 2; ++i) wish.aside_mps[i] = std::clamp(0.9 * view.offset_m(i), -0.6, 0.6);
  wish.sink_mps = view.distance_m() < 0.3 ? 0.4 : 0.05;
  return wish;
}

FlightResult fly_by_hand(const FlightOptions& options, std::vector<math::Vec3>* path = nullptr) {
  auto flight = LandingFlight::create(options);
  if (!flight) return {};
  while ((*flight)->next_decision()) (*flight)->act(by_hand((*flight)->view()));
  if (path) *path = (*flight)->path();
  return (*flight)->result();
}

TEST(LandingFlight, LandsWhereASimpleLawSteersIt) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const FlightResult result = fly_by_hand({.seed = seed});
    EXPECT_TRUE(result.good) << seed << ": " << result.error_m << " m, " << result.speed_mps << " m/s";
  }
}

TEST(LandingFlight, TheSameSeedIsTheSameFlight) {
  std::vector<math::Vec3> one, other, another;
  fly_by_hand({.seed = 5, .brief = true, .keep_path = true}, &one);
  fly_by_hand({.seed = 5, .brief = true, .keep_path = true}, &other);
  fly_by_hand({.seed = 6, .brief = true, .keep_path = true}, &another);
  ASSERT_GT(one.size(), 20u);
  EXPECT_EQ(one, other);
  EXPECT_NE(one, another);
}

TEST(LandingFlight, APolicyThatFliesAwayLosesThePad) {
  auto flight = LandingFlight::create({.seed = 1, .brief = true, .most_s = 40});
  ASSERT_TRUE(flight);
  while ((*flight)->next_decision()) (*flight)->act({{0.6, 0.6}, 0.05});
  EXPECT_TRUE((*flight)->result().lost);
  EXPECT_FALSE((*flight)->result().good);
}

std::string learned(Variant variant, std::uint64_t seed, std::uint64_t trials) {
  LandingSchool school(variant, seed);
  for (std::uint64_t i = 0; i < trials; ++i)
    if (!school.trial()) return "no world";
  return policy_file(school.policy(), "");
}

TEST(LandingSchool, TheSameSeedIsTheSamePolicyByteForByte) {
  for (const Variant variant : kVariants) {
    const std::string one = learned(variant, 7, 3);
    EXPECT_EQ(one, learned(variant, 7, 3)) << to_string(variant);
    EXPECT_NE(one, learned(variant, 8, 3)) << to_string(variant);
  }
}

TEST(LandingSchool, AShortLearningLandsOnThePad) {
  LandingSchool school(Variant::continuous, 1);
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(school.trial());
  const auto seen = evaluate(school.policy(), 5, true);
  ASSERT_TRUE(seen);
  EXPECT_GE(seen->good, 4u);
}

TEST(LandingSchool, AskedForABatchItLearnsFromAllFlightsAtOnce) {
  LandingSchool school(Variant::batch, 1);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(school.trial());
  const auto before = school.policy().aside.weights();
  EXPECT_TRUE(std::any_of(before.begin(), before.end(), [](double w) { return w != 0; }));
}

TEST(LandingSchool, ItsFileHasTheNumbersThatTheModuleTakes) {
  const control::LandingPolicy policy(control::LandingActions::continuous);
  const std::string text = policy_file(policy, "a remark");
  EXPECT_EQ(text.find("# a remark\n[landing]\nactions = \"continuous\"\naside = \"0 0 "), 0u);
}

}  // namespace
}  // namespace sinew::learning::landing_school_test
