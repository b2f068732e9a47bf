// The time line: its writing, its reading at the same time, the zones, and the trace for viewers.
#include "rt/exec/timeline.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "graph_fixture.hpp"
#include "hal/platform.hpp"
#include "rt/exec/chrome_trace.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/zone.hpp"
#include "test_modules.hpp"
#include "until.hpp"

namespace sinew::rt::timeline_test {
namespace {

using ::testing::ElementsAre;
using Kind = TimelineEvent::Kind;

std::vector<TimelineRing::Entry> entries(const TimelineRing& ring) {
  std::vector<TimelineRing::Entry> all;
  ring.read(all);
  return all;
}

TEST(TimelineRing, KeepsTheNewestEventsAsTheyWereWritten) {
  TimelineRing ring(8, Time{100});
  EXPECT_TRUE(entries(ring).empty());
  for (std::uint32_t i = 0; i < 21; ++i) ring.add(static_cast<Kind>(i % 8), Time{100 + i}, Duration{i * 7}, i);
  const auto all = entries(ring);
  ASSERT_EQ(all.size(), 8u);
  for (std::uint32_t k = 0; k < 8; ++k) {
    const std::uint32_t i = 13 + k;
    EXPECT_EQ(all[k].kind, static_cast<Kind>(i % 8));
    EXPECT_EQ(all[k].index, i);
    EXPECT_EQ(all[k].at, Time{100 + i});
    EXPECT_EQ(all[k].length, Duration{i * 7});
  }
}

TEST(TimelineRing, InstantsAndLengthsOutOfRangeBecomeTheNearestThatFit) {
  TimelineRing ring(4, Time{100});
  ring.add(Kind::step, Time{99}, Duration{-5}, 1);
  ring.add(Kind::step, Time{INT64_MAX}, Duration{INT64_MAX}, 4095);
  const auto all = entries(ring);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].at, Time{100});
  EXPECT_EQ(all[0].length, Duration{0});
  EXPECT_EQ(all[1].at, Time{100 + (std::int64_t{1} << 52) - 1});
  EXPECT_EQ(all[1].length, Duration{(std::int64_t{1} << 36) - 1});
  EXPECT_EQ(all[1].index, 4095u);
}

TEST(TimelineRing, AReaderSeesWholeEventsInOrderWhileTheyAreOverwritten) {
  TimelineRing ring(16, Time{0});
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (std::int64_t i = 1; !stop.load(std::memory_order_relaxed); ++i)
      ring.add(static_cast<Kind>(i % 8), Time{i}, Duration{i}, static_cast<std::uint32_t>(i % 4096));
  });
  std::vector<TimelineRing::Entry> all;
  std::size_t seen = 0, torn = 0;
  Time newest{};
  for (int round = 0; round < 200'000 || (seen < 1000 && round < 100'000'000); ++round) {
    all.clear();
    ring.read(all);
    Time before{};
    for (const auto& e : all) {
      const bool whole =
          e.at.ns == e.length.count() && e.index == e.at.ns % 4096 && e.kind == static_cast<Kind>(e.at.ns % 8);
      torn += !whole || e.at <= before;
      before = e.at;
    }
    seen += all.size();
    newest = std::max(newest, before);
  }
  stop = true;
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_GT(newest.ns, 16) << "it was read while it was overwritten";
}

TEST(TimelineRing, MoreZonesThanItCanNameAreTheOtherOne) {
  TimelineRing ring(4, Time{0});
  std::vector<std::string> names;
  for (int i = 0; i < 100; ++i) names.push_back("zone" + std::to_string(i));
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(ring.zone(names[i].c_str(), i), std::min(i, 63u));
  EXPECT_EQ(ring.zone(names[5].c_str(), 5), 5u);
  EXPECT_STREQ(ring.zone_name(5).name, "zone5");
  EXPECT_EQ(ring.zone_name(5).module, 5u);
  EXPECT_STREQ(ring.zone_name(63).name, "other");
  EXPECT_STREQ(ring.zone_name(64).name, "?");
}

// ---- what a run writes

std::string text(const Robot& robot, const TimelineEvent& e, const Graph& graph) {
  static const char* const kinds[] = {"release", "cycle",     "step",          "overrun",
                                      "skip",    "preempted", "off_processor", "zone"};
  (void)robot;
  std::string s = graph.threads()[e.thread].spec.name + " " + kinds[static_cast<int>(e.kind)];
  if (e.module != kNone) s += " " + graph.modules()[e.module].spec.name;
  if (e.zone) s += std::string(" ") + e.zone;
  return s + " " + std::to_string(e.at.ns / 1000) + "+" + std::to_string(e.length.count() / 1000);
}

std::vector<std::string> lines(Robot& robot) {
  std::vector<std::string> all;
  for (const TimelineEvent& e : robot.runner().timeline().snapshot()) all.push_back(text(robot, e, robot.graph()));
  return all;
}

/// `low` works 700 us of every 2 ms, `high` 200 us of every 500 us.
struct Preempting : Robot {
  Preempting() {
    add<Numbers>("fast");
    add<Numbers>("slow");
    add<Numbers>("after");
    module("fast").exec.constant = 200us;
    module("slow").exec.constant = 600us;
    module("after").exec.constant = 100us;
    periodic("high", 20, 500us, {"fast"}).phase = 100us;
    periodic("low", 10, 2ms, {"slow", "after"});
  }
};

TEST(Timeline, HasReleasesStepsCyclesAndPreemptionsToTheNanosecond) {
  Preempting robot;
  robot.run(1200us);
  EXPECT_THAT(lines(robot),
              ElementsAre("low cycle 0+1100", "low step slow 0+1000", "low release 0+0", "high cycle 100+200",
                          "high step fast 100+200", "low preempted 100+200", "high release 100+0", "high cycle 600+200",
                          "high step fast 600+200", "low preempted 600+200", "high release 600+0",
                          "low step after 1000+100", "high release 1100+0"));
}

TEST(Timeline, HasReleasesThatMetAnUnfinishedCycle) {
  Robot robot;
  robot.add<Numbers>("skips");
  robot.add<Numbers>("waits");
  robot.module("skips").exec.constant = 1500us;
  robot.module("waits").exec.constant = 1500us;
  robot.spec.virtual_cores = 2;
  robot.periodic("skip", 20, 1ms, {"skips"});
  robot.periodic("wait", 10, 1ms, {"waits"}).overrun = ThreadSpec::Overrun::catch_up;
  robot.run(2400us);
  std::map<std::string, int> found;
  for (const auto& line : lines(robot)) ++found[line];
  EXPECT_EQ(found["skip skip 1000+0"], 1);
  EXPECT_EQ(found["wait overrun 1000+0"], 1);
  EXPECT_EQ(found["wait release 1000+500"], 1) << "its cycle began 500 us late";
}

TEST(Timeline, ASnapshotReachesBackAsFarAsItIsAsked) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"});
  robot.run(500'500us);
  const auto of = [&](Duration last) { return robot.runner().timeline().snapshot(last); };
  EXPECT_EQ(of(10ms).size(), 3u * 11 - 1) << "what ended in the 10 ms before 500.01 ms: all but the release at 490 ms";
  EXPECT_EQ(of(10s).size(), 3u * 501);
}

/// Two zones, one in the other.
class Zoned final : public Module {
 public:
  void declare(Declaration&) override {}
  StepStatus step(const Step& step) noexcept override {
    const Zone outer(step, "outer");
    steps.fetch_add(1);
    const Zone inner(step, "inner \"quoted\"");
    return StepStatus::ok;
  }
  std::atomic<int> steps{0};
};

std::size_t zones(const std::vector<TimelineEvent>& events) {
  return static_cast<std::size_t>(
      std::count_if(events.begin(), events.end(), [](const auto& e) { return e.kind == Kind::zone; }));
}

TEST(Zones, AreWrittenOnlyWhileSomebodyAsks) {
  Robot robot;
  robot.add<Zoned>("zoned");
  robot.periodic("main", 10, 1ms, {"zoned"});
  Graph& graph = robot.build();
  robot.grants.end = Time{9'500'000};
  DiscreteExecutor executor(graph, robot.clock, robot.grants);
  robot.grants.at(Time{2'500'000}, [&] { executor.runner().ask_for_zones(true); });
  robot.grants.at(Time{5'500'000}, [&] { executor.runner().ask_for_zones(false); });
  ASSERT_TRUE(executor.run());
  const auto events = executor.runner().timeline().snapshot();
  std::vector<std::string> found;
  for (const auto& e : events)
    if (e.kind == Kind::zone) found.push_back(text(robot, e, graph));
  EXPECT_THAT(found, ElementsAre("main zone zoned inner \"quoted\" 3000+0", "main zone zoned outer 3000+0",
                                 "main zone zoned inner \"quoted\" 4000+0", "main zone zoned outer 4000+0",
                                 "main zone zoned inner \"quoted\" 5000+0", "main zone zoned outer 5000+0"));
}

bool within(const TimelineEvent& inner, const TimelineEvent& outer) {
  return inner.thread == outer.thread && inner.at >= outer.at && inner.at + inner.length <= outer.at + outer.length;
}

TEST(Zones, LieInsideTheirStepsInRealTime) {
  Robot robot;
  robot.virtual_time = false;
  Zoned& zoned = robot.add<Zoned>("zoned");
  robot.periodic("main", 10, 1ms, {"zoned"});
  RealTimeOptions options;
  options.start_delay = 1ms;
  options.lock_memory = false;
  RealTimeExecutor executor(robot.build(), hal::system_os(), options);
  ASSERT_TRUE(executor.start());
  executor.runner().ask_for_zones(true);
  std::size_t while_running = 0;
  until([&] {
    while_running = zones(executor.runner().timeline().snapshot());
    return zoned.steps.load() >= 30 && while_running > 0;
  });
  executor.stop();
  EXPECT_GT(while_running, 0u) << "it can be read while it is written";
  const auto events = executor.runner().timeline().snapshot();
  ASSERT_GE(zones(events), 10u);
  for (const auto& zone : events) {
    if (zone.kind != Kind::zone) continue;
    EXPECT_TRUE(std::any_of(events.begin(), events.end(), [&](const auto& step) {
      return step.kind == Kind::step && step.module == zone.module && within(zone, step);
    })) << text(robot, zone, robot.graph());
  }
}

// ---- the trace for viewers

/// Slices of one track either follow each other or lie in each other.
void expect_nested(const nlohmann::json& events) {
  std::map<int, std::vector<double>> open;  // per track: ends, the outermost first
  std::map<int, double> last;
  for (const auto& e : events) {
    if (e["ph"] != "X") continue;
    const int tid = e["tid"];
    const double begin = e["ts"], end = begin + e["dur"].get<double>();
    EXPECT_GE(begin, last[tid]);
    last[tid] = begin;
    auto& ends = open[tid];
    while (!ends.empty() && ends.back() <= begin) ends.pop_back();
    EXPECT_TRUE(ends.empty() || end <= ends.back() + 0.0005) << e.dump();
    ends.push_back(end);
  }
}

TEST(ChromeTrace, IsJsonOfTheTraceEventFormat) {
  Preempting robot;
  robot.spec.robot = "prober";
  robot.add<Zoned>("zoned");
  robot.spec.threads[1].order.push_back({"zoned", 0});
  Graph& graph = robot.build();
  robot.grants.end = Time{50'000'000};
  DiscreteExecutor executor(graph, robot.clock, robot.grants);
  executor.runner().ask_for_zones(true);
  ASSERT_TRUE(executor.run());
  const auto events = executor.runner().timeline().snapshot();
  const auto trace = nlohmann::json::parse(chrome_trace(graph, events));
  ASSERT_TRUE(trace["traceEvents"].is_array());
  EXPECT_EQ(trace["displayTimeUnit"], "ns");
  std::map<std::string, int> phases, names;
  std::map<int, std::string> threads;
  for (const auto& e : trace["traceEvents"]) {
    const std::string phase = e["ph"], name = e["name"];
    ++phases[phase];
    ++names[name];
    EXPECT_EQ(e["pid"], 1);
    EXPECT_TRUE(e["tid"].is_number_integer());
    if (name == "thread_name") threads[e["tid"]] = e["args"]["name"];
    if (name == "process_name") {
      EXPECT_EQ(e["args"]["name"], "prober");
    }
    if (phase == "M") continue;
    EXPECT_TRUE(e["ts"].is_number());
    if (phase == "X") {
      EXPECT_GE(e["dur"].get<double>(), 0);
    } else {
      EXPECT_EQ(phase, "i");
      EXPECT_EQ(e["s"], "t");
    }
  }
  EXPECT_EQ(phases["M"] + phases["X"] + phases["i"], static_cast<int>(trace["traceEvents"].size()));
  EXPECT_EQ(static_cast<std::size_t>(phases["X"] + phases["i"]), events.size());
  EXPECT_THAT(threads, ElementsAre(std::pair(1, "high"), std::pair(2, "low")));
  EXPECT_EQ(names["fast"], 100);
  EXPECT_EQ(names["slow"], 25);
  EXPECT_EQ(names["outer"], 25);
  EXPECT_EQ(names["inner \"quoted\""], 25);
  EXPECT_GT(names["preempted"], 20);
  expect_nested(trace["traceEvents"]);
}

TEST(ChromeTrace, TimesAreMicrosecondsWithThreeDecimals) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"});
  const std::vector<TimelineEvent> events = {{Kind::step, 0, 0, Time{1'234'567'890'123'456'789}, Duration{1'005}},
                                             {Kind::release, 0, kNone, Time{-1'500}, Duration{7}}};
  const std::string trace = chrome_trace(robot.build(), events);
  EXPECT_THAT(trace, ::testing::HasSubstr("\"ts\":1234567890123456.789,\"dur\":1.005}"));
  EXPECT_THAT(trace, ::testing::HasSubstr("\"ts\":-1.500,\"args\":{\"late_us\":0.007}}"));
}

}  // namespace
}  // namespace sinew::rt::timeline_test
