#include "record/run/comparison.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "chained_robot.hpp"

namespace sinew::record::comparison_test {
namespace {

using ::testing::Contains;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::Not;
using ::testing::Pair;

const ComparedQuantity& find(const std::vector<ComparedQuantity>& all, std::string_view name) {
  return *std::find_if(all.begin(), all.end(), [&](const auto& q) { return q.name == name; });
}

class ComparisonTest : public ::testing::Test {
 protected:
  std::vector<ComparedQuantity> compare(ComparisonOptions options, const std::vector<ChainedRobot::Change>& changes) {
    std::optional<Comparison> comparison;
    ReplayOptions replay{.chain = true};
    flight_.again(replay, changes, [&](Reader& reader, rt::Graph& graph) {
      options.record = recorded_time(reader);
      replay.watcher = &comparison.emplace(graph, options);
    });
    return comparison->result();
  }
  ChainedRobot flight_;
};

TEST_F(ComparisonTest, GivesRmsMaximumAndWhenTheMaximumWas) {
  flight_.fly(100ms);
  const auto all = compare({}, {{"numbers", "gain", 1.5}});
  const ComparedQuantity& gain = find(all, "numbers.out.value[0]");
  EXPECT_EQ(gain.now.count, 100u);
  EXPECT_DOUBLE_EQ(gain.now.rms(), 0.5);
  EXPECT_EQ(gain.now.max, 0.5);
  EXPECT_EQ(gain.now.max_at, rt::Time{0}) << "the first of them";
  EXPECT_TRUE(std::isinf(gain.relative())) << "it never moved";
  EXPECT_TRUE(find(all, "numbers.out.value[1]").same());
  EXPECT_EQ(find(all, "numbers.out.value[1]").relative(), 0);
  // The follower sums it up, every 5 ms: it differs by 0.5, 1, ... 10 from 1, 2, ... 20.
  const ComparedQuantity& sum = find(all, "follower.out.value[3]");
  EXPECT_EQ(sum.now.count, 20u);
  EXPECT_NEAR(sum.now.rms(), std::sqrt(0.25 * 20 * 21 * 41 / 6 / 20), 1e-12);
  EXPECT_EQ(sum.now.max, 10);
  EXPECT_EQ(sum.now.max_at, rt::Time{95'020'000}) << "behind the others of its instant";
  EXPECT_NEAR(sum.spread, std::sqrt((20.0 * 20 - 1) / 12), 1e-12);
  EXPECT_NEAR(sum.relative(), sum.now.rms() / sum.spread, 1e-15);
}

TEST_F(ComparisonTest, LooksAtTheWantedQuantitiesModulesAndTimeOnly) {
  flight_.fly(100ms);
  const std::vector<ChainedRobot::Change> louder{{"numbers", "gain", 1.5}};
  const auto some =
      compare({.quantities = {"follower.out.number", "value[0]"}, .modules = {"follower", "sieve"}}, louder);
  std::vector<std::string> names;
  for (const auto& q : some) names.push_back(q.name);
  EXPECT_THAT(names, ElementsAre("follower.out.number", "follower.out.value[0]", "sieve.out.value[0]"));
  const auto late = compare({.from_s = 0.05, .until_s = 0.06}, louder);
  EXPECT_EQ(find(late, "numbers.out.value[0]").now.count, 11u);
  EXPECT_EQ(find(late, "numbers.out.value[0]").now.max_at, rt::Time{50'000'000});
}

TEST_F(ComparisonTest, ACurveKeepsWhatStandsOut) {
  flight_.fly(2s);  // more messages than stretches
  const auto all = compare({.quantities = {"numbers.out.value[1]"}, .curves = true}, {});
  ASSERT_EQ(all.size(), 1u);
  ASSERT_EQ(all[0].curves.size(), 2u);
  EXPECT_EQ(all[0].curves[0].first, "recorded");
  EXPECT_EQ(all[0].curves[1].first, "now");
  Curve curve({rt::Time{0}, 10s});
  for (std::int64_t i = 0; i < 10'000; ++i) curve.add(rt::Time{i * 1'000'000}, i == 4321 ? 9 : i == 4325 ? -9 : 1);
  curve.add(rt::Time{5'000'000'000}, NAN);
  const auto points = curve.points();
  EXPECT_LE(points.size(), 1200u);
  EXPECT_THAT(points, Contains(Pair(DoubleNear(4.321, 1e-9), 9.0)));
  EXPECT_THAT(points, Contains(Pair(DoubleNear(4.325, 1e-9), -9.0)));
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](auto& a, auto& b) { return a.first < b.first; }));
}

TEST_F(ComparisonTest, ANumberInOneOfBothOnlyIsCountedApart) {
  flight_.fly(10ms);
  const rt::Graph& graph = flight_.robot.graph();
  Comparison comparison(graph, {.quantities = {"numbers.out.value"}});
  struct Slot {
    rt::SlotHeader header;
    rt::Pair pair;
  } was, is;
  const auto show = [&](double recorded, double now) {
    was.pair.value[0] = recorded, is.pair.value[0] = now;
    comparison.compared({graph.find_topic("numbers.out"), rt::Time{7}, was.header, is.header});
  };
  show(1, NAN);
  show(NAN, NAN);
  show(INFINITY, INFINITY);
  show(1, 2);
  const auto all = comparison.result();
  EXPECT_EQ(all[0].one_sided, 1u);
  EXPECT_EQ(all[0].now.count, 1u);
  EXPECT_EQ(all[0].now.rms(), 1);
  EXPECT_FALSE(all[0].same());
}

TEST_F(ComparisonTest, NamesWhatThereIsToCompare) {
  flight_.fly(10ms);
  const auto names = quantity_names(flight_.robot.graph(), {"sieve"});
  EXPECT_THAT(names, Contains("sieve.out.value[3]"));
  EXPECT_THAT(names, Not(Contains("numbers.out.number")));
}

}  // namespace
}  // namespace sinew::record::comparison_test
