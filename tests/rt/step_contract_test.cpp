// The step contract (docs/design.md, section 3) on small graphs in virtual time.
#include <gtest/gtest.h>

#include "counting_new.hpp"
#include "graph_fixture.hpp"

namespace sinew::rt {
namespace {

constexpr std::size_t kRoom = 10'000;

void writes(Declaration& d, Probe& p) { d.out("out", p.out); }
void reads(Declaration& d, Probe& p) { d.in("in", p.in); }

/// Publishes 0, 1, 2, ... with the step's instant as stamp.
Status counts(Probe& p, const Step& step) {
  Pair& out = p.out.loan();
  out.stamp = step.now;
  out.number = step.number;
  return Status::ok;
}

class StepContract : public ::testing::Test {
 protected:
  StepContract() {
    seen.reserve(kRoom);
    instants.reserve(kRoom);
  }
  GraphRig g;
  std::vector<std::int64_t> seen;      // what a test's module noted; -1: nothing there
  std::vector<std::int64_t> instants;  // in microseconds

  GraphRig::Steps notes_number() {
    return [this](Probe& p, const Step& step) {
      seen.push_back(p.in.get() ? std::int64_t{p.in.get()->number} : -1);
      instants.push_back(step.now.ns / 1000);
      return Status::ok;
    };
  }
};

using Numbers = std::vector<std::int64_t>;

TEST_F(StepContract, ModulesOfAThreadRunInTheOrderOfTheFileAndSeeTheSameCycle) {
  g.module("src", writes, {}, counts, 100us);
  g.module("ctl", reads, {{"in", "src.out"}}, notes_number());
  g.periodic("t", 1, 1ms, {"src", "ctl"});
  ASSERT_EQ(g.build(), "");
  g.run(3500us);
  EXPECT_EQ(seen, (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(instants, (Numbers{100, 1100, 2100, 3100}));
}

TEST_F(StepContract, PreviousGivesTheMessageOfTheCycleBefore) {
  g.module(
      "ctl", [](Declaration& d, Probe& p) { d.in("in", p.in, {.previous = true}); }, {{"in", "src.out"}},
      notes_number());
  g.module("src", writes, {}, counts);
  g.periodic("t", 1, 1ms, {"ctl", "src"});
  ASSERT_EQ(g.build(), "");
  g.run(2500us);
  EXPECT_EQ(seen, (Numbers{-1, 0, 1}));
}

TEST_F(StepContract, OutputsAppearWhenTheExecutionTimeIsUsedUp) {
  g.spec.virtual_cores = 2;
  g.module("src", writes, {}, counts, 300us);
  g.module("ctl", reads, {{"in", "src.out"}}, notes_number());
  g.periodic("a", 2, 1ms, {"src"});
  g.periodic("b", 1, 100us, {"ctl"});
  ASSERT_EQ(g.build(), "");
  g.run(500us);
  EXPECT_EQ(seen, (Numbers{-1, -1, -1, 0, 0, 0})) << "at 300 us the step completes before the other one starts";
}

TEST_F(StepContract, PreemptionDelaysTheOutputs) {
  g.module("src", writes, {}, counts, 300us);
  g.module("ctl", reads, {{"in", "src.out"}}, notes_number(), 50us);
  g.periodic("a", 1, 10ms, {"src"});
  g.periodic("b", 2, 100us, {"ctl"});
  ASSERT_EQ(g.build(), "");
  g.run(600us);
  // a has the core for 50 us of every 100 us: it completes at 600 us
  EXPECT_EQ(seen, (Numbers{-1, -1, -1, -1, -1, -1, 0}));
  EXPECT_EQ(g.runner().thread_stats(0).preemptions.value(), 5u);
}

TEST_F(StepContract, InputsAreLatchedOnceForTheWholeStep) {
  g.module("src", writes, {}, counts);
  g.module("slow", reads, {{"in", "src.out"}}, notes_number(), 5ms);
  g.periodic("a", 2, 1ms, {"src"});
  g.periodic("b", 1, 10ms, {"slow"}).phase = 500us;
  ASSERT_EQ(g.build(), "");
  const Pair* latched = nullptr;
  std::int64_t at_end = -1;
  g.probes["slow"]->steps = [&](Probe& p, const Step&) {
    latched = p.in.get();
    return Status::ok;
  };
  g.probes["slow"]->emits = [&](Probe& p, Time) {
    EXPECT_EQ(p.in.get(), latched);
    at_end = p.in.get()->number;
  };
  g.run(9ms);
  EXPECT_EQ(at_end, 0) << "five commits came during the step";
  EXPECT_GT(g.runner().topic_stats(g.topic("src.out")).messages.value(), 8u);
}

TEST_F(StepContract, AllOutputsOfAStepBecomeVisibleTogether) {
  g.module(
      "src",
      [](Declaration& d, Probe& p) {
        d.out("out", p.out);
        d.out("second", p.second);
      },
      {},
      [](Probe& p, const Step& step) {
        if (step.number % 3 == 2) return Status::stale;
        p.out.loan().number = step.number;
        p.second.loan().number = step.number;
        return Status::ok;
      },
      130us);
  g.module(
      "ctl",
      [](Declaration& d, Probe& p) {
        d.in("in", p.in);
        d.in("other", p.other);
      },
      {{"in", "src.out"}, {"other", "src.second"}},
      [this](Probe& p, const Step&) {
        const Pair *a = p.in.get(), *b = p.other.get();
        seen.push_back((a ? std::int64_t{a->number} : -1) - (b ? std::int64_t{b->number} : -1));
        return Status::ok;
      },
      70us);
  g.periodic("a", 1, 230us, {"src"});
  g.periodic("b", 2, 170us, {"ctl"});
  ASSERT_EQ(g.build(), "");
  g.run(100ms);
  EXPECT_EQ(seen, Numbers(589, 0));
}

TEST_F(StepContract, AStaleOrFaultyStepPublishesNothing) {
  g.module("src", writes, {}, [](Probe& p, const Step& step) {
    p.out.loan().number = step.number;
    return step.number % 3 == 0 ? Status::ok : step.number % 3 == 1 ? Status::stale : Status::fault;
  });
  g.module("ctl", reads, {{"in", "src.out"}}, notes_number());
  g.periodic("t", 1, 1ms, {"src", "ctl"});
  ASSERT_EQ(g.build(), "");
  g.run(6500us);
  EXPECT_EQ(seen, (Numbers{0, 0, 0, 3, 3, 3, 6}));
  const ModuleStats& s = g.runner().module_stats(g.graph->find_module("src"));
  EXPECT_EQ(s.steps.value(), 7u);
  EXPECT_EQ(s.ok.value(), 3u);
  EXPECT_EQ(s.stale.value(), 2u);
  EXPECT_EQ(s.fault.value(), 2u);
  EXPECT_EQ(g.runner().topic_stats(g.topic("src.out")).messages.value(), 3u);
}

TEST_F(StepContract, ReadersSeeTheSlotThatTheWriterFilled) {
  const void *written = nullptr, *near = nullptr, *far = nullptr;
  g.module("src", writes, {}, [&](Probe& p, const Step& step) {
    if (step.number > 0) return Status::ok;
    written = &p.out.loan();
    return Status::ok;
  });
  g.module("ctl", reads, {{"in", "src.out"}}, [&](Probe& p, const Step&) {
    near = p.in.get();
    return Status::ok;
  });
  g.module("vis", reads, {{"in", "src.out"}}, [&](Probe& p, const Step&) {
    far = p.in.get();
    return Status::ok;
  });
  g.periodic("a", 2, 1ms, {"src", "ctl"});
  g.periodic("b", 1, 1ms, {"vis"});
  ASSERT_EQ(g.build(), "");
  g.run(1500us);
  ASSERT_NE(written, nullptr);
  EXPECT_EQ(near, written);
  EXPECT_EQ(far, written);
}

TEST_F(StepContract, AQueueHoldsAllEventsSinceTheLastStepAndCountsWhatItLost) {
  g.module("src", writes, {}, counts);
  g.module(
      "log", [](Declaration& d, Probe& p) { d.in("queue", p.queue, {.depth = 4}); }, {{"queue", "src.out"}},
      [this](Probe& p, const Step&) {
        for (const Pair& e : p.queue) seen.push_back(e.number);
        return Status::ok;
      });
  g.periodic("a", 2, 1ms, {"src"});
  g.periodic("b", 1, 6ms, {"log"}).phase = 2500us;
  ASSERT_EQ(g.build(), "");
  g.run(9ms);
  EXPECT_EQ(seen, (Numbers{0, 1, 2, 5, 6, 7, 8}));
  EXPECT_EQ(g.runner().topic_drops(g.topic("src.out")), 2u);
}

TEST_F(StepContract, DtIsReleaseToRelease) {
  g.module("src", {}, {}, [this](Probe&, const Step& step) {
    seen.push_back(step.dt.count() / 1000);
    return Status::ok;
  });
  g.spec.modules[0].exec = {ExecModel::Kind::trace, {}, {100us, 2500us, 100us, 100us}, 1.0};
  g.periodic("t", 1, 1ms, {"src"}).phase = 300us;
  ASSERT_EQ(g.build(), "");
  g.run(6ms);
  // released at 0.3, 1.3 (until 3.8), 4.3, 5.3
  EXPECT_EQ(seen, (Numbers{1000, 1000, 3000, 1000}));
}

TEST_F(StepContract, ATimeOutIsToldToTheStep) {
  g.module("src", writes, {}, counts);
  g.module("ctl", reads, {{"in", "src.out"}}, [this](Probe&, const Step& step) {
    seen.push_back(step.timed_out);
    instants.push_back(step.now.ns / 1000);
    return Status::ok;
  });
  g.periodic("a", 2, 10ms, {"src"}).phase = 2ms;
  g.on_topic("b", 1, "src.out", {"ctl"}).timeout = 4ms;
  ASSERT_EQ(g.build(), "");
  g.run(12100us);
  EXPECT_EQ(instants, (Numbers{2010, 6010, 10010, 12010}));
  EXPECT_EQ(seen, (Numbers{0, 1, 1, 0}));
  EXPECT_EQ(g.runner().thread_stats(1).timeouts.value(), 2u);
}

void collects_imu(GraphRig& g, Probe& p) {
  p.behind = &g.board.imu_device;
  p.collects = [&g](Probe& probe, Time) {
    msg::ImuSample sample;
    while (*g.board.imu_device.read(sample)) {
      Pair* raw = probe.raw.loan();
      raw->stamp = sample.stamp;
    }
  };
}

TEST_F(StepContract, ADeviceReleasesItsThreadAtTheInstantOfItsSample) {
  for (const int us : {500, 1700, 1750, 9000}) g.board.imu_device.due.push_back(Time{us * 1000});
  g.module("imu", {}, {}, {}, 100us);
  g.module(
      "nav", [](Declaration& d, Probe& p) { d.in("queue", p.queue); }, {{"queue", "imu.raw"}},
      [this](Probe& p, const Step& step) {
        instants.push_back(-step.now.ns / 1000);
        seen.push_back(static_cast<std::int64_t>(p.queue.size()));
        return Status::ok;
      },
      100us);
  ThreadSpec& t = g.thread("sense", 5, {"imu"});
  t.trigger = ThreadSpec::Trigger::device;
  t.device_module = "imu";
  g.on_topic("nav", 2, "imu.raw", {"nav"});
  g.types.add("test::imu", [this] {
    auto probe = std::make_unique<Probe>();
    probe->declares = [](Declaration& d, Probe& p) { d.raw("raw", p.raw); };
    probe->steps = [this](Probe& p, const Step& step) {
      instants.push_back(step.now.ns / 1000);
      seen.push_back(static_cast<std::int64_t>(p.raw.size()));
      return Status::ok;
    };
    collects_imu(g, *probe);
    return probe;
  });
  ASSERT_EQ(g.build(), "");
  g.run(20ms);
  // The raw topic triggers nav when it is filled; nav, less urgent, runs when imu has completed. The sample of 1750
  // waits until imu's cycle of 1700 is over, and preempts nothing: nav begins at 1900 with both.
  EXPECT_EQ(instants, (Numbers{500, -600, 1700, 1800, -1900, 9000, -9100}));
  EXPECT_EQ(seen, (Numbers{1, 1, 1, 1, 2, 1, 1}));
  EXPECT_EQ(g.runner().thread_stats(1).coalesced.value(), 1u);
}

TEST_F(StepContract, AModuleThatFaultsTooOftenIsStoppedAndTheOthersGoOn) {
  g.module("bad", {}, {}, [](Probe&, const Step&) { return Status::fault; });
  g.module("good", {}, {}, [](Probe&, const Step&) { return Status::ok; });
  g.periodic("t", 1, 1ms, {"bad", "good"});
  g.options.fault_limit = 4;
  ASSERT_EQ(g.build(), "");
  g.run(19500us);
  const ModuleStats& bad = g.runner().module_stats(0);
  EXPECT_EQ(bad.steps.value(), 4u);
  EXPECT_EQ(bad.stops.value(), 1u);
  EXPECT_EQ(bad.stopped.value(), 1u);
  EXPECT_EQ(g.runner().module_stats(1).steps.value(), 20u);
}

TEST_F(StepContract, AnOkStepForgivesEarlierFaults) {
  g.module("bad", {}, {}, [](Probe&, const Step& s) { return s.number % 4 == 3 ? Status::ok : Status::fault; });
  g.periodic("t", 1, 1ms, {"bad"});
  g.options.fault_limit = 4;
  ASSERT_EQ(g.build(), "");
  g.run(19500us);
  EXPECT_EQ(g.runner().module_stats(0).steps.value(), 20u);
}

TEST_F(StepContract, ChainsAgeFromTheFirstStampToTheLastCommit) {
  g.module("src", writes, {}, counts, 200us);
  g.module(
      "mid",
      [](Declaration& d, Probe& p) {
        d.in("in", p.in);
        d.in("back", p.back, {.optional = true, .previous = true});
        d.out("out", p.out);
      },
      {{"in", "src.out"}, {"back", "end.out"}}, counts, 300us);
  g.module(
      "end",
      [](Declaration& d, Probe& p) {
        d.in("in", p.in);
        d.out("out", p.out);
      },
      {{"in", "mid.out"}}, counts, 100us);
  g.periodic("t", 1, 1ms, {"src", "mid", "end"});
  g.spec.chains.push_back({"all", {"src.out", 0}, {"end.out", 0}, 550us, 0});
  g.spec.chains.push_back({"half", {"src.out", 0}, {"mid.out", 0}, 550us, 0});
  ASSERT_EQ(g.build(), "");
  g.run(99900us);
  const ChainStats& all = g.runner().chain_stats(0);
  EXPECT_EQ(all.age.count(), 100u);
  EXPECT_EQ(all.age.min(), 600us);
  EXPECT_EQ(all.age.max(), 600us) << "the way back from end to mid carries no origin";
  EXPECT_EQ(all.budget_misses.value(), 100u);
  EXPECT_EQ(g.runner().chain_stats(1).age.max(), 500us);
  EXPECT_EQ(g.runner().chain_stats(1).budget_misses.value(), 0u);
}

TEST_F(StepContract, AChainDoesNotAgeInALoopAheadOfItsEnd) {
  const auto two_in_one_out = [](Declaration& d, Probe& p) {
    d.in("in", p.in);
    d.in("back", p.back, {.optional = true, .previous = true});
    d.out("out", p.out);
  };
  g.module("src", writes, {}, counts, 200us);
  g.module("mid", two_in_one_out, {{"in", "src.out"}, {"back", "mid.out"}}, counts, 300us);
  g.module("end", two_in_one_out, {{"in", "mid.out"}}, counts, 100us);
  g.periodic("t", 1, 1ms, {"src", "mid", "end"});
  g.spec.chains.push_back({"all", {"src.out", 0}, {"end.out", 0}, 0us, 0});
  ASSERT_EQ(g.build(), "");
  g.run(99900us);
  EXPECT_EQ(g.runner().chain_stats(0).age.count(), 100u);
  EXPECT_EQ(g.runner().chain_stats(0).age.max(), 600us);
}

TEST_F(StepContract, TheLoopAllocatesNothing) {
  g.module("src", writes, {}, counts);
  g.module("ctl", reads, {{"in", "src.out"}});
  g.periodic("a", 2, 1ms, {"src"});
  g.on_topic("b", 1, "src.out", {"ctl"}).timeout = 5ms;
  g.options.hash_topics = true;
  ASSERT_EQ(g.build(), "");
  hal::FixedGrant grants(Time{} + 1s);
  DiscreteExecutor executor(*g.graph, g.clock, grants, g.options);
  const std::size_t before = test::allocations();
  const auto report = executor.run();
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(report->reached, Time{} + 1s);
}

}  // namespace
}  // namespace sinew::rt
