// The modules of the shipped robots, executed again from the record of a flight: each must come to the same bytes from
// the beginning and from every saved state. This finds a module that keeps a value from step to step and does not
// declare it as state.
#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "../rt/memory_record.hpp"
#include "fault_world.hpp"
#include "source_dir.hpp"

namespace sinew::app::test::flight_again_test {
namespace {

/// What happens in a run, at an instant of it, once.
struct Event {
  Time at;
  std::function<void(rt::Graph&, FaultWorld&)> act;
};

/// A robot file's modules in the tests' world, recorded.
class RecordedRun {
 public:
  RecordedRun(const std::string& robot, Duration duration, std::vector<Event> events = {},
              const std::function<void(rt::GraphSpec&)>& change = {})
      : events_(std::move(events)) {
    auto loaded = load_robot(sinew::test::source_dir() + "/robots/" + robot);
    EXPECT_TRUE(loaded.problems.empty());
    spec = std::move(loaded.robot.graph);
    if (change) change(spec);
    graph = std::make_unique<rt::Graph>(spec, types);
    for (const auto& p : graph->check({.virtual_time = true})) ADD_FAILURE() << rt::to_string(p, robot);
    world = std::make_unique<FaultWorld>(clock_, 20ms);
    EXPECT_TRUE(graph->configure(*world));
    record = std::make_unique<rt::MemoryRecord>(*graph, 1s);
    world->end = Time{duration.count()};
    world->look = [this](Time now) {
      for (Event& e : events_)
        if (e.act && now >= e.at) std::exchange(e.act, nullptr)(*graph, *world);
    };
    rt::DiscreteOptions options;
    options.observer = record.get();
    executor = std::make_unique<rt::DiscreteExecutor>(*graph, clock_, *world, options);
    EXPECT_TRUE(executor->run());
  }
  std::uint32_t size() const { return static_cast<std::uint32_t>(graph->modules().size()); }
  std::uint32_t id(std::string_view module) const { return graph->find_module(module); }
  const std::string& name(std::uint32_t module) const { return graph->modules()[module].spec.name; }

  /// All modules again, each from its saved state number `from` (0: from the beginning) for `length` of the run.
  void expect_the_same(std::size_t from, Duration length = Duration{INT64_MAX / 2}) {
    rt::RunAgain again(spec, types);
    ASSERT_TRUE(again.configured());
    for (std::uint32_t m = 0; m < size(); ++m) {
      const auto saved = record->saved(m);
      if (from > saved.size()) continue;  // it was stopped by then
      const std::size_t begin = from == 0 ? 0 : saved[from - 1] + 1;
      std::size_t end = begin;
      const auto& all = record->of(m);
      const Time first = begin == 0 ? Time{} : all[begin - 1].step.now;
      while (end < all.size() && (all[end].request || all[end].step.now - first < length)) ++end;
      const auto departure = again.run(m, all, begin, end);
      EXPECT_FALSE(departure) << name(m) << " from saved state " << from << ": at "
                              << msg::seconds(all[departure->entry].step.now - Time{}) << " s: " << departure->what;
    }
  }

  rt::GraphSpec spec;
  const rt::ModuleTypes types = all_modules();
  std::unique_ptr<rt::Graph> graph;
  std::unique_ptr<FaultWorld> world;
  std::unique_ptr<rt::MemoryRecord> record;
  std::unique_ptr<rt::DiscreteExecutor> executor;

 private:
  hal::ManualClock clock_;
  std::vector<Event> events_;
};

constexpr Duration kFlight = 17s;

std::vector<Event> flight_events() {
  const auto at = [](Duration t) { return Time{t.count()}; };
  return {
      {at(4s), [](auto& g, auto&) { EXPECT_TRUE(g.set_param("attitude", "kp_tilt", 6.5)); }},
      {at(5s), [](auto& g, auto&) { EXPECT_TRUE(g.set_enabled("battery", false)); }},
      {at(6s), [](auto& g, auto&) { EXPECT_TRUE(g.set_enabled("battery", true)); }},
      {at(6500ms), [](auto& g, auto&) { EXPECT_TRUE(g.set_period("navigate", 4ms)); }},
      {at(7s), [](auto&, auto& w) { w.camera_works = false; }},
      {at(7300ms), [](auto&, auto& w) { w.camera_works = true; }},
      {at(8s), [](auto& g, auto&) { EXPECT_TRUE(g.set_enabled("motion", false)); }},
      {at(9s), [](auto& g, auto&) { EXPECT_TRUE(g.set_enabled("motion", true)); }},
      {at(10s), [](auto&, auto& w) { w.voltage_v = 12; }},             // the guardian asks to land
      {at(15500ms), [](auto& g, auto&) { EXPECT_TRUE(g.disarm()); }},  // and stops the motors
  };
}

/// One flight for all tests.
RecordedRun& flight() {
  static RecordedRun run("quad/quad.toml", kFlight, flight_events(), [](rt::GraphSpec& spec) {
    for (rt::ModuleSpec& m : spec.modules)
      if (m.name == "mission") {  // takes longer than its period now and then
        m.exec.kind = rt::ExecModel::Kind::trace;
        m.exec.trace.assign(399, m.exec.constant);
        m.exec.trace.push_back(7ms);
      }
  });
  return run;
}

TEST(FlightAgain, TheFlightHasWhatARunCanHaveInIt) {
  RecordedRun& f = flight();
  EXPECT_GT(f.executor->runner().thread_stats(f.graph->find_thread("navigate")).overruns.value(), 0u);
  EXPECT_EQ(f.executor->runner().thread_stats(f.graph->find_thread("navigate")).period_ns.value(), 4'000'000);
  EXPECT_GT(f.record->steps(f.id("filter")), 14'000u);
  EXPECT_GT(f.record->steps(f.id("motion")), 380u);
  EXPECT_GT(f.world->largest_tilt_rad, 0.02) << "it flew";
  std::uint32_t acted = 0;
  const auto& ports = f.graph->modules()[f.id("guardian")].declaration.ports;
  for (const rt::KeptEntry& e : f.record->of(f.id("guardian")))
    for (std::size_t p = 0; p < e.out.size(); ++p)
      for (const rt::SlotHeader* h : e.out[p])
        if (ports[p].name == "state") acted |= static_cast<const msg::SafetyState*>(h->message())->acted;
  EXPECT_NE(acted, 0u) << "the guardian did something";
}

TEST(FlightAgain, EveryModuleOfTheQuadDoesTheSameFromTheBeginning) { flight().expect_the_same(0); }

TEST(FlightAgain, EveryModuleOfTheQuadDoesTheSameFromEverySavedState) {
  const std::size_t saved = flight().record->saved(0).size();
  EXPECT_EQ(saved, 17u);
  for (std::size_t from = 1; from <= saved; ++from) flight().expect_the_same(from, 1500ms);
}

TEST(FlightAgain, FromASavedStateItIsTheSameToTheEnd) {
  flight().expect_the_same(3);
  flight().expect_the_same(9);
}

TEST(FlightAgain, AMemberThatWasForgottenWouldBeFound) {
  RecordedRun& f = flight();
  const std::set<std::string> not_needed{"attitude 1", "attitude 2",  // it did not tip over
                                         "filter 1", "filter 2"};     // and saw neither GNSS nor a second IMU
  std::uint32_t members = 0;
  for (std::uint32_t m = 1; m < f.size(); ++m) {  // 0 is the guardian: rt's own test
    const std::size_t states = f.graph->modules()[m].declaration.states.size();
    for (std::uint32_t i = 0; i < states; ++i, ++members) {
      const std::string member = f.name(m) + " " + std::to_string(i);
      EXPECT_EQ(rt::forgetting_is_noticed(f.spec, f.types, *f.record, m, i), !not_needed.contains(member)) << member;
    }
  }
  EXPECT_EQ(members, 13u);
}

TEST(FlightAgain, OneBitOfAnInertialSampleIsNoticedWhereItWasUsed) {
  RecordedRun& f = flight();
  auto& entries = f.record->of(f.id("filter"));
  std::size_t at = entries.size() / 2;
  while (entries[at].request || entries[at].step.status != rt::StepStatus::ok || entries[at].in[0].messages.empty())
    ++at;
  auto* sample = static_cast<msg::ImuSample*>(const_cast<rt::SlotHeader*>(entries[at].in[0].messages[0])->message());
  const double right = sample->gyro_radps.y;
  sample->gyro_radps.y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(right) ^ 1u << 20);
  rt::RunAgain again(f.spec, f.types);
  const auto departure = again.run(f.id("filter"), entries, 0, entries.size());
  sample->gyro_radps.y = right;
  ASSERT_TRUE(departure);
  EXPECT_EQ(departure->entry, at);
}

TEST(FlightAgain, EveryModuleOfTheDatasetRobotDoesTheSameFromEverySavedState) {
  RecordedRun run("mav_dataset/mav_dataset.toml", 5s);
  EXPECT_GT(run.record->steps(run.id("motion")), 100u);
  run.expect_the_same(0);
  for (std::size_t from = 1; from < 5; ++from) run.expect_the_same(from);
}

TEST(StateOfModules, ATypeDeclaresItsStateOrIsKnownToHaveNone) {
  const std::set<std::string> stateless{
      "control::TeamLocator",   "control::Mixer",       "vision::PadDetector", "vision::BallDetector",
      "mixed::OrangeBall",  // look at each picture by itself
      "drivers::GnssSource",    "drivers::JointSource", "drivers::MagSource",  "drivers::RcSource",
      "drivers::ImuSource",     "drivers::RangeSource", "drivers::BaroSource", "drivers::BatterySource",
      "drivers::CameraSource",  "drivers::RadioSource", "drivers::TextSource", "drivers::SoleSource",
      "drivers::RefereeSource", "app::GroundTruth",     "air_robot::TextPose", "air_robot::Steer",
      "app::StateLog",
      "app::MotionLog",  // publish nothing: what they keep is for the
                         // report
  };
  const rt::ModuleTypes types = all_modules();
  for (const std::string& name : types.names()) {
    rt::Declaration d;
    const auto module = types.make(name);
    module->declare(d);
    EXPECT_EQ(d.states.empty(), stateless.contains(name)) << name;
  }
}

}  // namespace
}  // namespace sinew::app::test::flight_again_test
