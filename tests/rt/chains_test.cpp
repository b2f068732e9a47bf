// Where origins of chains travel, and how old they are at the end.
#include <gtest/gtest.h>

#include "graph_fixture.hpp"
#include "test_modules.hpp"

namespace sinew::rt::chains_test {
namespace {

/// Publishes a stamp that lies some time back.
class Sensor final : public Module {
 public:
  explicit Sensor(Duration lag) : lag_(lag) {}
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    out_.loan().stamp = step.now - lag_;
    return StepStatus::ok;
  }

 private:
  const Duration lag_;
  Out<Pair> out_;
};

class Fusion final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("a", a_);
    d.in("b", b_);
    d.out("out", out_);
  }
  StepStatus step(const Step& step) noexcept override {
    out_.loan().stamp = step.now;
    return StepStatus::ok;
  }

 private:
  In<Pair> a_, b_;
  Out<Pair> out_;
};

TEST(Chains, TheAgeOfATopicLeavesOutWhatWasNeverMeasured) {
  // A joint that is absent from the start has the stamp 0: how long ago the clock began says nothing of the topic.
  struct Absent final : Module {
    void declare(Declaration& d) override { d.out("out", out); }
    StepStatus step(const Step& step) noexcept override {
      out.loan().stamp = step.now < Time{} + 35ms ? Time{} : step.now - 2ms;
      return StepStatus::ok;
    }
    Out<Pair> out;
  };
  Robot robot;
  robot.add<Absent>("absent", {});
  robot.periodic("main", 10, 10ms, {"absent"});
  robot.run(55ms);
  const TopicStats& stats = robot.runner().topic_stats(robot.graph().find_topic("absent.out"));
  EXPECT_EQ(stats.messages.value(), 6u);
  EXPECT_EQ(stats.age.count(), 2u);
  EXPECT_LT(stats.age.max(), Duration{3ms});
}

TEST(Chains, TheAgeIsThatOfTheOldestThatWentIn) {
  Robot robot;
  robot.add<Sensor>("near", {}, 1ms);
  robot.add<Sensor>("far", {}, 5ms);
  robot.add<Fusion>("fusion", {{"a", "near.out"}, {"b", "far.out"}});
  robot.add<Relay>("end", {{"in", "fusion.out"}});
  robot.periodic("main", 10, 10ms, {"near", "far", "fusion", "end"});
  robot.spec.chains.push_back({"near", {"near.out", 0}, {"end.out", 0}, 0ms, 0});
  robot.spec.chains.push_back({"far", {"far.out", 0}, {"end.out", 0}, 0ms, 0});
  robot.run(55ms);
  const ChainStats& near = robot.runner().chain_stats(0);
  const ChainStats& far = robot.runner().chain_stats(1);
  EXPECT_EQ(near.age.count(), 6u);
  EXPECT_EQ(near.age.max(), Duration{1ms + 40us}) << "stamped at its start, 4 steps of 10 us to the end";
  EXPECT_EQ(near.age.min(), near.age.max());
  EXPECT_EQ(far.age.max(), Duration{5ms + 30us});
}

TEST(Chains, OneTopicThatCarriesTwoMessagesMergesToTheOlder) {
  Robot robot;  // one source, two ways of different age to the same end
  robot.add<Numbers>("source");
  robot.add<Relay>("old_way", {{"in", "source.out"}});
  robot.add<Fusion>("fusion", {{"a", "source.out"}, {"b", "old_way.out"}});
  robot.periodic("fast", 20, 1ms, {"source"});
  robot.periodic("slow", 15, 8ms, {"old_way"}).phase = 100us;
  robot.periodic("end", 10, 1ms, {"fusion"}).phase = 200us;
  robot.spec.chains.push_back({"chain", {"source.out", 0}, {"fusion.out", 0}, 4ms, 0});
  robot.run(80ms);
  const ChainStats& chain = robot.runner().chain_stats(0);
  EXPECT_EQ(chain.age.count(), 80u);
  EXPECT_EQ(chain.age.min(), Duration{210us});
  EXPECT_EQ(chain.age.max(), Duration{7ms + 210us});
  EXPECT_EQ(chain.budget_misses.value(), 10u * 4u) << "ages of 4.21, 5.21, 6.21 and 7.21 ms of each 8";
}

TEST(Chains, AnInputThatDoesNotLeadThereCarriesNothing) {
  Robot robot;  // the ring end -> fusion must not keep an origin alive
  robot.add<Sensor>("source", {}, 2ms);
  class Loop final : public Module {
   public:
    void declare(Declaration& d) override {
      d.in("in", in_);
      d.in("back", back_, {.previous = true});
      d.out("out", out_);
    }
    StepStatus step(const Step& step) noexcept override {
      out_.loan().stamp = step.now;
      return StepStatus::ok;
    }

   private:
    In<Pair> in_, back_;
    Out<Pair> out_;
  };
  robot.add<Loop>("loop", {{"in", "source.out"}, {"back", "end.out"}});
  robot.add<Relay>("end", {{"in", "loop.out"}});
  robot.periodic("main", 10, 10ms, {"source", "loop", "end"});
  robot.spec.chains.push_back({"chain", {"source.out", 0}, {"end.out", 0}, 0ms, 0});
  robot.run(95ms);
  EXPECT_EQ(robot.runner().chain_stats(0).age.count(), 10u);
  EXPECT_EQ(robot.runner().chain_stats(0).age.max(), Duration{2ms + 30us}) << "does not grow from cycle to cycle";
}

TEST(Chains, NoOriginNoAge) {
  Robot robot;
  robot.add<Numbers>("source");
  robot.module("source").enabled = false;
  robot.add<Fusion>("fusion", {{"a", "source.out"}, {"b", "source.out"}});
  robot.periodic("main", 10, 1ms, {"source", "fusion"});
  robot.spec.chains.push_back({"chain", {"source.out", 0}, {"fusion.out", 0}, 1ms, 0});
  robot.run(9500us);
  EXPECT_EQ(robot.runner().topic_stats(robot.graph().find_topic("fusion.out")).messages.value(), 10u);
  EXPECT_EQ(robot.runner().chain_stats(0).age.count(), 0u);
}

}  // namespace
}  // namespace sinew::rt::chains_test
