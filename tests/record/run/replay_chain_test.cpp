#include "record/run/replay_chain.hpp"

#include <gmock/gmock.h>

#include "chained_robot.hpp"

namespace sinew::record::replay_chain_test {
namespace {

using ::testing::HasSubstr;

/// The messages that one topic has now.
class Kept final : public ReplayWatcher {
 public:
  explicit Kept(std::uint32_t topic) : topic_(topic) {}
  void compared(const ReplayedMessage& m) override {
    if (m.topic != topic_) return;
    recorded.push_back(*static_cast<const rt::Pair*>(m.recorded.message()));
    again.push_back(*static_cast<const rt::Pair*>(m.again.message()));
  }
  std::vector<rt::Pair> recorded, again;

 private:
  std::uint32_t topic_;
};

class ReplayChainTest : public ::testing::Test {
 protected:
  std::uint32_t topic(std::string_view name) { return flight_.robot.graph().find_topic(name); }
  static const ReplayedModule& of(const ReplayReport& report, std::string_view name) {
    return ChainedRobot::of(report, name);
  }
  ChainedRobot flight_;
};

TEST_F(ReplayChainTest, WithoutChangesEverythingIsIdentical) {
  flight_.robot.grants.at(rt::Time{100'500'000},
                          [this] { ASSERT_TRUE(flight_.robot.graph().set_param("sieve", "every", std::int64_t{3})); });
  flight_.fly(1s);
  const ReplayReport report = flight_.again({.chain = true});
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_TRUE(report.complete());
  EXPECT_EQ(of(report, "numbers").messages, 1000u);
  EXPECT_EQ(of(report, "follower").messages, 200u);
  for (const auto& m : report.modules) EXPECT_EQ(m.missing + m.extra + m.not_compared, 0u) << m.name;
}

TEST_F(ReplayChainTest, WhatAModulePublishesNowReachesTheOthers) {
  flight_.fly(100ms);
  const std::vector<ChainedRobot::Change> louder{{"numbers", "gain", 1.5}};
  EXPECT_FALSE(of(flight_.again({}, louder), "follower").difference) << "else it is held against the record alone";
  Kept kept(topic("follower.out"));
  const ReplayReport report = flight_.again({.chain = true, .watcher = &kept}, louder);
  EXPECT_TRUE(of(report, "numbers").difference);
  EXPECT_TRUE(of(report, "sieve").difference);
  ASSERT_TRUE(of(report, "follower").difference);
  EXPECT_EQ(of(report, "follower").steps, 20u) << "it goes on behind a difference";
  EXPECT_EQ(of(report, "follower").differing, 20u);
  for (std::size_t i = 0; i < kept.again.size(); ++i) {
    EXPECT_EQ(kept.recorded[i].value[0], 1.0);
    EXPECT_EQ(kept.again[i].value[0], 1.5);
  }
}

TEST_F(ReplayChainTest, AModuleThatIsNotExecutedAgainFeedsWhatItDid) {
  flight_.fly(100ms);
  const ReplayReport report =
      flight_.again({.modules = {"numbers", "follower"}, .chain = true}, {{"numbers", "gain", 1.5}});
  EXPECT_TRUE(of(report, "numbers").difference);
  EXPECT_FALSE(of(report, "follower").difference) << "the sieve between them stands as recorded";
}

TEST_F(ReplayChainTest, WhatIsNotPublishedNowIsNotLatched) {
  flight_.fly(100ms);
  Kept kept(topic("follower.out"));
  const ReplayReport report = flight_.again({.chain = true, .watcher = &kept}, {{"sieve", "every", std::int64_t{20}}});
  EXPECT_EQ(of(report, "sieve").missing, 45u);
  EXPECT_EQ(of(report, "sieve").extra, 0u);
  EXPECT_EQ(of(report, "sieve").difference->what, "status");
  ASSERT_EQ(kept.again.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {  // at 0, 5, 10, ... ms, after the numbers of then
    const rt::Pair &was = kept.recorded[i], &now = kept.again[i];
    EXPECT_EQ(now.number, was.number / 20 * 20) << "the newest that there is";
    const bool fresh = i == 0 || now.number != kept.again[i - 1].number;
    EXPECT_EQ(now.value[2], fresh ? 1 : 0) << i;
    EXPECT_EQ(now.value[1], fresh ? 1 : 0) << "and in the queue only what is new";
  }
}

TEST_F(ReplayChainTest, WhatIsPublishedBeyondIsCountedAndReadByNobody) {
  flight_.fly(100ms);
  const ReplayReport report = flight_.again({.chain = true}, {{"sieve", "every", std::int64_t{1}}});
  EXPECT_EQ(of(report, "sieve").extra, 50u);
  EXPECT_EQ(of(report, "sieve").missing, 0u);
  EXPECT_FALSE(of(report, "follower").difference);
}

TEST_F(ReplayChainTest, WhoReadsOfAModuleThatEndsEarlyEndsToo) {
  flight_.fly(100ms, {.rate_hz = {{"numbers.out", 100}}});
  const ReplayReport report = flight_.again({.modules = {"sieve", "follower"}, .chain = true});
  EXPECT_THAT(of(report, "sieve").stopped, HasSubstr("is not in the file"));
  EXPECT_THAT(of(report, "follower").stopped,
              HasSubstr("input latest: message 4294967042 was not published again: its writer ended before"));
  EXPECT_TRUE(flight_.again({.chain = true}).complete()) << "what is published again need not be in the file";
}

TEST_F(ReplayChainTest, BeginsAtSavedStatesWithTheRecordedMessagesOfBefore) {
  RecorderOptions options;
  options.state_every = 47ms;  // in ever other phases of the threads
  flight_.fly(400ms, options);
  bool later = false;  // a writer began behind its reader
  for (double from_s = 0.15; from_s < 0.4; from_s += 0.01) {
    const ReplayReport report = flight_.again({.from_s = from_s, .chain = true});
    EXPECT_EQ(report.first_difference(), nullptr) << from_s;
    EXPECT_TRUE(report.complete()) << from_s;
    for (const ReplayedModule& m : report.modules) {
      ASSERT_TRUE(m.from) << m.name;
      EXPECT_GT(m.steps, 0u) << m.name;
    }
    later |= *of(report, "sieve").from > *of(report, "follower").from + 10ms;
  }
  EXPECT_TRUE(later);
}

TEST_F(ReplayChainTest, EndsWhereItIsToldTo) {
  flight_.fly(400ms);
  const ReplayReport report = flight_.again({.until_s = 0.1});
  EXPECT_EQ(of(report, "numbers").steps, 100u);
  EXPECT_TRUE(report.complete());
}

TEST_F(ReplayChainTest, AKeptParameterIsNotSetByTheRecord) {
  flight_.robot.grants.at(rt::Time{50'500'000},
                          [this] { ASSERT_TRUE(flight_.robot.graph().set_param("numbers", "gain", 2.5)); });
  flight_.fly(100ms);
  const ReplayReport set = flight_.again({}, {{"numbers", "gain", 1.0}});
  EXPECT_EQ(set.first_difference(), nullptr);
  const ReplayReport kept = flight_.again({.keep = {"numbers.gain"}}, {{"numbers", "gain", 1.0}});
  ASSERT_TRUE(of(kept, "numbers").difference);
  EXPECT_EQ(of(kept, "numbers").difference->step, 51u);
  EXPECT_EQ(of(kept, "numbers").difference->recorded, "2.5");
  EXPECT_EQ(of(kept, "numbers").settings_ignored, 1u);
}

}  // namespace
}  // namespace sinew::record::replay_chain_test
