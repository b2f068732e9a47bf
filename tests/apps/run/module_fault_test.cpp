// Every fault of every module of the quadrotor in turn, in virtual time: the reaction to it, and exactly when. The
// cells come from the graph; a cell that the table below does not have fails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "fault_world.hpp"

namespace sinew::app::test::module_fault_test {
namespace {

using msg::FailsafeAction;
using msg::MissionPhase;

constexpr Time kFault{8'000'300'000};  // in the air, between two releases of all threads
constexpr Duration kFlight = 40s;
constexpr std::uint32_t kFaultLimit = 10;  // DiscreteOptions

const std::map<Fault, std::string> kNames = {
    {Fault::disabled, "disabled"}, {Fault::stalled, "stalled"},           {Fault::failing, "failing"},
    {Fault::silent, "silent"},     {Fault::not_a_number, "not_a_number"}, {Fault::out_of_range, "out_of_range"},
    {Fault::too_fast, "too_fast"}, {Fault::bit_flipped, "bit_flipped"}};

struct Cell {
  std::string module, output;  // output: empty for a fault of the module
  Fault fault;
  /// A test's name.
  std::string name() const { return module + (output.empty() ? "" : "_" + output) + "_" + kNames.at(fault); }
};

void PrintTo(const Cell& cell, std::ostream* out) { *out << cell.name(); }

/// The outcome of a fault.
struct Outcome {
  enum class Kind {
    stops,     // no more commands: the actuators' safe action when the lease of the last one is over
    at_once,   // the guardian refuses the first broken command
    failsafe,  // this condition acts when it is due, and the vehicle lands
    unseen,    // no range fits any more: the estimator says so after its time, ground_unseen acts, and it lands
    nothing,   // the flight goes on to its end
    bounded,   // whatever it comes to, only valid commands reach the motors
  } kind;
  std::string why{};  // failsafe: its name; nothing, bounded: the reason
};
Outcome stops() { return {Outcome::Kind::stops}; }
Outcome at_once() { return {Outcome::Kind::at_once}; }
Outcome failsafe(std::string name) { return {Outcome::Kind::failsafe, std::move(name)}; }
Outcome unseen() { return {Outcome::Kind::unseen}; }
Outcome nothing(std::string why) { return {Outcome::Kind::nothing, std::move(why)}; }
Outcome bounded(std::string why) { return {Outcome::Kind::bounded, std::move(why)}; }

const char* const kValid =
    "numbers that could be true: no check can tell; the estimator's gates and the law's limits remain";
const char* const kNoReader = "nobody reads it";
const char* const kNoReport = "it is never written in a room";

/// Faults of the module and silence of its one output come to the same.
std::map<std::string, Outcome> without(const std::string& module, const std::string& output, const Outcome& o) {
  std::map<std::string, Outcome> some;
  for (const char* fault : {"disabled", "stalled", "failing"}) some.emplace(module + "_" + fault, o);
  some.emplace(module + "_" + output + "_silent", o);
  return some;
}

std::map<std::string, Outcome> table() {
  std::map<std::string, Outcome> t = {
      {"imu_raw_not_a_number", stops()},
      {"imu_raw_out_of_range", stops()},
      {"imu_raw_too_fast", nothing("samples of no duration change nothing")},
      {"imu_raw_bit_flipped", bounded(kValid)},
      {"filter_state_not_a_number", stops()},
      {"filter_state_out_of_range", stops()},
      {"filter_state_too_fast", stops()},  // swings between quaternions that are none
      {"filter_state_bit_flipped", bounded(kValid)},
      {"filter_report_silent", nothing(kNoReport)},
      {"filter_report_not_a_number", nothing(kNoReport)},
      {"filter_report_out_of_range", nothing(kNoReport)},
      {"filter_report_too_fast", nothing(kNoReport)},
      {"filter_report_bit_flipped", nothing(kNoReport)},
      {"attitude_wrench_not_a_number", stops()},
      {"attitude_wrench_out_of_range", stops()},
      {"attitude_wrench_too_fast", bounded(kValid)},
      {"attitude_wrench_bit_flipped", bounded(kValid)},
      {"mixer_motors_not_a_number", at_once()},
      {"mixer_motors_out_of_range", at_once()},
      {"mixer_motors_too_fast", at_once()},
      {"mixer_motors_bit_flipped", bounded(kValid)},
      {"mission_setpoint_not_a_number", stops()},
      {"mission_setpoint_out_of_range", stops()},
      {"mission_setpoint_too_fast", bounded(kValid)},
      {"mission_setpoint_bit_flipped", bounded(kValid)},
      {"mission_mission_silent", nothing(kNoReader)},
      {"mission_mission_not_a_number", nothing(kNoReader)},
      {"mission_mission_out_of_range", nothing(kNoReader)},
      {"mission_mission_too_fast", nothing(kNoReader)},
      {"mission_mission_bit_flipped", nothing(kNoReader)},
      {"position_attitude_not_a_number", stops()},
      {"position_attitude_out_of_range", stops()},
      {"position_attitude_too_fast", stops()},
      {"position_attitude_bit_flipped", bounded(kValid)},
      {"range_raw_not_a_number", unseen()},
      {"range_raw_out_of_range", unseen()},
      {"range_raw_too_fast", nothing("the same height many times")},
      {"range_raw_bit_flipped", bounded(kValid)},
      {"baro_disabled", nothing("the range finder gives the height")},
      {"baro_failing", nothing("the range finder gives the height")},
      {"baro_stalled", failsafe("range_lost")},  // is in its thread
      {"baro_raw_silent", nothing("the range finder gives the height")},
      {"baro_raw_not_a_number", nothing("refused")},
      {"baro_raw_out_of_range", nothing("refused")},
      {"baro_raw_too_fast", nothing("the same pressure many times")},
      {"baro_raw_bit_flipped", nothing("used only while the range finder is silent")},
      {"battery_raw_not_a_number", failsafe("battery_low")},
      {"battery_raw_out_of_range", failsafe("battery_low")},
      {"battery_raw_too_fast", nothing("a state: the newest counts")},
      {"battery_raw_bit_flipped", bounded(kValid)},
      {"camera_raw_not_a_number", nothing("pictures have no real numbers")},
      {"camera_raw_out_of_range", failsafe("sightings_lost")},  // a header that describes no picture
      {"camera_raw_too_fast", nothing("a camera has no more pictures than it took")},
      {"camera_raw_bit_flipped", nothing("one pixel is not a pad")},
      {"pad_sighting_not_a_number", bounded("refused: the mission searches the pad again, and lands where it is")},
      {"pad_sighting_out_of_range", bounded("refused: the mission searches the pad again, and lands where it is")},
      {"pad_sighting_too_fast", bounded("refused: the mission searches the pad again, and lands where it is")},
      {"pad_sighting_bit_flipped", bounded(kValid)},
      {"motion_disabled", nothing(kNoReader)},
      {"motion_stalled", failsafe("camera_lost")},  // is in its thread, and wrote before it
      {"motion_failing", nothing(kNoReader)},
      {"motion_field_silent", nothing(kNoReader)},
      {"motion_field_not_a_number", nothing(kNoReader)},
      {"motion_field_out_of_range", nothing(kNoReader)},
      {"motion_field_too_fast", nothing(kNoReader)},
      {"motion_field_bit_flipped", nothing(kNoReader)}};
  t.merge(without("imu", "raw", stops()));
  t.merge(without("filter", "state", stops()));
  t.merge(without("attitude", "wrench", stops()));
  t.merge(without("mixer", "motors", stops()));
  t.merge(without("mission", "setpoint", stops()));
  t.merge(without("position", "attitude", stops()));
  t.merge(without("range", "raw", failsafe("range_lost")));
  t.merge(without("battery", "raw", failsafe("battery_unknown")));
  t.emplace("camera_stalled", failsafe("sightings_lost"));  // the last ones are of the picture before
  t.merge(without("camera", "raw", failsafe("camera_lost")));
  t.merge(without("pad", "sighting", failsafe("sightings_lost")));
  return t;
}

std::vector<Cell> all_cells() {
  std::vector<Cell> cells;
  const FaultFlight quad;
  const rt::Graph graph(quad.spec, quad.types);
  for (const rt::GraphModule& m : graph.modules()) {
    if (m.guardian) continue;  // without it the lease and the parent act
    for (const Fault f : kModuleFaults) cells.push_back({m.spec.name, "", f});
    for (const auto& p : m.declaration.ports)
      if (p.output)
        for (const Fault f : kOutputFaults) cells.push_back({m.spec.name, p.name, f});
  }
  return cells;
}

/// How long commands may go on without this module: on the shortest path to them, every reader may use its last message
/// for its max_age, and looks once a period.
Duration dries_up_within(const rt::Graph& graph, const std::string& module, const std::string& command) {
  std::vector<Duration> within(graph.modules().size(), Duration::max());
  within[graph.find_module(module)] = Duration{0};
  for (std::size_t round = 0; round < within.size(); ++round)
    for (std::uint32_t m = 0; m < within.size(); ++m)
      for (std::size_t p = 0; p < graph.modules()[m].topic.size(); ++p) {
        const auto& port = graph.modules()[m].declaration.ports[p];
        if (port.output || port.optional || graph.modules()[m].topic[p] == rt::kNone) continue;
        const Duration before = within[graph.topics()[graph.modules()[m].topic[p]].writer];
        if (before == Duration::max()) continue;
        const Duration age = port.kind == rt::Declaration::PortKind::queue ? Duration{0} : port.max_age;
        if (age > Duration{1h}) continue;
        within[m] = std::min(within[m], before + age + graph.threads()[graph.modules()[m].thread].spec.period);
      }
  return within[graph.topics()[graph.find_topic(command)].writer];
}

class ModuleFault : public ::testing::TestWithParam<Cell> {
 protected:
  /// The lease of the last good command runs out: to the nanosecond, after what the graph allows at most.
  void expect_stopped_by_the_lease(FaultFlight& f) {
    const Duration lease = f.spec.actuators[0].lease, guardian = f.spec.guardian.exec.constant;
    const Time last = f.last_published(f.spec.actuators[0].command.value);
    const auto stop = f.first_stop_since(kFault);
    ASSERT_TRUE(stop);
    EXPECT_EQ(*stop, last + lease + guardian);
    Duration most = dries_up_within(*f.graph, GetParam().module, f.spec.actuators[0].command.value);
    if (GetParam().fault == Fault::failing) most += kFaultLimit * 1ms;  // a driver's samples come until it is stopped
    EXPECT_LE((last - kFault).count(), most.count());
    EXPECT_FALSE(f.any_write_since(*stop)) << "and stays stopped";
  }
  void expect_stopped_at_once(FaultFlight& f) {
    const auto stop = f.first_stop_since(kFault);
    ASSERT_TRUE(stop);
    const Time next_command{(kFault.ns / 1'000'000 + 1) * 1'000'000 + 29'000};  // 1 kHz; imu, filter, attitude, mixer
    const Time swing = next_command + (GetParam().fault == Fault::too_fast ? 1ms : 0ms);  // takes two to be one
    EXPECT_GE(*stop, next_command + f.spec.guardian.exec.constant);
    EXPECT_LE(*stop, swing + f.spec.guardian.exec.constant);
  }
  /// Which condition is due first, and when, follows from when its topic was last written; it acts in the guardian's
  /// next step, and the mission lands.
  void expect_failsafe(FaultFlight& f, const std::string& name) {
    Time due{INT64_MAX};
    std::string first;
    for (const rt::FailsafeSpec& s : f.spec.failsafes) {
      Time at{INT64_MAX};
      if (s.kind == rt::FailsafeSpec::Kind::silent) at = f.last_published(s.topic.value) + s.time;
      if (s.kind == rt::FailsafeSpec::Kind::value && s.name == name) at = first_bad_value(f) + s.time;
      if (at < due) due = at, first = s.name;
    }
    EXPECT_EQ(first, name);
    ASSERT_FALSE(f.actions.empty());
    EXPECT_EQ(f.actions[0].state.action, FailsafeAction::land);
    EXPECT_EQ(f.actions[0].at, f.guardian_step_since(due));
    EXPECT_LE((f.actions[0].at - due).count(), rt::Guardian::check_interval(f.spec.actuators).count());
    expect_landed(f);
  }
  /// The last range that fitted is at most its period before the fault; a state and a guardian's step come each
  /// millisecond.
  static void expect_ground_unseen(FaultFlight& f) {
    const auto& all = f.spec.failsafes;
    const auto it = std::find_if(all.begin(), all.end(), [](const auto& s) { return s.name == "ground_unseen"; });
    ASSERT_NE(it, all.end());
    ASSERT_FALSE(f.actions.empty());
    EXPECT_EQ(f.actions[0].state.action, FailsafeAction::land);
    EXPECT_EQ(f.actions[0].state.acted, 1u << (it - all.begin()));
    const Duration after = f.actions[0].at - kFault, due = 300ms + it->time;
    EXPECT_GE(after.count(), (due - 20ms).count());
    EXPECT_LE(after.count(), (due + 3ms).count());
    expect_landed(f);
  }
  /// This module is stopped after its tenth fault in a row, and no other is.
  static void expect_only_this_module_stopped(FaultFlight& f) {
    for (std::uint32_t m = 0; m < f.graph->modules().size(); ++m) {
      const rt::ModuleStats& stats = f.executor->runner().module_stats(m);
      const bool failing = f.graph->modules()[m].spec.name == GetParam().module;
      EXPECT_EQ(stats.stops.value(), failing ? 1u : 0u) << f.graph->modules()[m].spec.name;
      EXPECT_EQ(stats.fault.value(), failing ? kFaultLimit : 0u) << f.graph->modules()[m].spec.name;
    }
  }
  static void expect_landed(const FaultFlight& f) {
    EXPECT_LT(f.world->model.truth().p_world_m.z, 0.13);
    EXPECT_EQ(f.world->motors.at(f.clock.now())[0], 0) << "and its motors stand";
    EXPECT_LT(f.world->fastest_fall_mps, 1.0);
  }
  /// Commit of the first battery sample after the fault: the thread's next release.
  static Time first_bad_value(const FaultFlight& f) { return f.first_battery_since(kFault); }

  void expect_nothing(FaultFlight& f) {
    EXPECT_TRUE(f.actions.empty());
    EXPECT_EQ(std::count(f.phases.begin(), f.phases.end(), MissionPhase::abort), 0);
    expect_landed(f);
  }
};

TEST_P(ModuleFault, EndsAsConfigured) {
  const Cell& cell = GetParam();
  static const std::map<std::string, Outcome> outcomes = table();
  const auto known = outcomes.find(cell.name());
  ASSERT_NE(known, outcomes.end()) << "nobody has said what happens then";
  const Outcome& expected = known->second;

  FaultFlight f([&](rt::GraphSpec& spec) {
    if (cell.module == "mixer" && cell.fault == Fault::too_fast) spec.actuators[0].rate_per_s = 800;
  });
  f.poison(cell.module, {cell.fault, cell.output, kFault});
  f.fly(expected.kind == Outcome::Kind::stops || expected.kind == Outcome::Kind::at_once ? 9s : kFlight);
  EXPECT_EQ(f.world->motors.wrong, 0) << "what reached the motors";
  ASSERT_TRUE(f.any_write_since(kFault - 2ms)) << "it was in the air";
  if (cell.fault == Fault::failing) expect_only_this_module_stopped(f);
  switch (expected.kind) {
    case Outcome::Kind::stops:
      return expect_stopped_by_the_lease(f);
    case Outcome::Kind::at_once:
      return expect_stopped_at_once(f);
    case Outcome::Kind::failsafe:
      return expect_failsafe(f, expected.why);
    case Outcome::Kind::unseen:
      return expect_ground_unseen(f);
    case Outcome::Kind::nothing:
      return expect_nothing(f);
    case Outcome::Kind::bounded:
      return;
  }
}
INSTANTIATE_TEST_SUITE_P(Quad, ModuleFault, ::testing::ValuesIn(all_cells()),
                         [](const auto& cell) { return cell.param.name(); });

/// Every output wrong for 5 ms, less than any lease or max_age: flown through, and nothing of it stays in a filter or
/// an integrator.
class ShortFault : public ::testing::TestWithParam<Cell> {};

TEST_P(ShortFault, IsFlownThrough) {
  const Cell& cell = GetParam();
  FaultFlight f;
  f.poison(cell.module, {cell.fault, cell.output, kFault, kFault + 5ms});
  f.fly(kFlight);
  EXPECT_EQ(f.world->motors.wrong, 0);
  EXPECT_TRUE(f.actions.empty());
  ASSERT_FALSE(f.phases.empty());
  EXPECT_EQ(f.phases.back(), MissionPhase::done);
  EXPECT_EQ(std::count(f.phases.begin(), f.phases.end(), MissionPhase::abort), 0);
  EXPECT_LT(f.world->fastest_fall_mps, 1.0);
}

std::vector<Cell> short_cells() {
  std::vector<Cell> cells;
  for (const Cell& c : all_cells())
    if (c.fault == Fault::silent || c.fault == Fault::not_a_number || c.fault == Fault::out_of_range)
      cells.push_back(c);
  return cells;
}
INSTANTIATE_TEST_SUITE_P(Quad, ShortFault, ::testing::ValuesIn(short_cells()),
                         [](const auto& cell) { return cell.param.name(); });

TEST(ModuleFaultTable, NamesOnlyFaultsThatExist) {
  std::set<std::string> names;
  for (const Cell& c : all_cells()) names.insert(c.name());
  for (const auto& [name, outcome] : table()) EXPECT_TRUE(names.contains(name)) << name;
}

TEST(ModuleFaultTable, WithoutAFaultTheFlightEndsOnThePad) {
  FaultFlight f;
  f.fly(kFlight);
  ASSERT_FALSE(f.phases.empty());
  EXPECT_EQ(f.phases.back(), MissionPhase::done);
  EXPECT_EQ(f.world->motors.wrong, 0);
  EXPECT_TRUE(f.actions.empty());
  const math::Vec3 away = f.world->model.truth().p_world_m - FakeCamera::kPad;
  EXPECT_LT(math::hypot(away.x, away.y), 0.1);
}

}  // namespace
}  // namespace sinew::app::test::module_fault_test
