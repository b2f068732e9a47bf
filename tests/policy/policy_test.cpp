// A network as a module: what it observes, what it commands, what it remembers.
#include "policy/policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../../bench/model_writer.hpp"
#include "msg/actuators.hpp"
#include "msg/sensors.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::policy::policy_test {
namespace {

using namespace std::chrono_literals;
using onnx::test::ModelWriter;
using rt::StepStatus;
using rt::Time;
using ::testing::ElementsAre;
using ::testing::FloatEq;
using ::testing::HasSubstr;

std::shared_ptr<const PolicyFile> file_of(const ModelWriter& m) {
  return std::make_shared<const PolicyFile>(PolicyFile{"walk.onnx", "", m.bytes(), ""});
}
/// y = x.
ModelWriter mirror(std::int64_t size) {
  ModelWriter m;
  return m.input("obs", {1, size}).output("actions", {1, size}).node("Identity", {"obs"}, {"actions"});
}
/// y = sum of x, h_out = h + sum of x.
ModelWriter counter() {
  ModelWriter m;
  m.input("obs", {1, 2}).input("h", {1, 1}).output("actions", {1, 1}).output("h_out", {1, 1});
  m.weight("ones", {2, 1}, {1, 1}).node("MatMul", {"obs", "ones"}, {"sum"}).node("Add", {"sum", "h"}, {"h_out"});
  return m.node("Identity", {"h_out"}, {"actions"});
}

Observed imu(std::vector<std::string> fields) {
  Observed e;
  e.key = "module.walk.observe.0";
  e.topic = "imu.raw";
  e.fields = std::move(fields);
  return e;
}
Commanded motor(std::vector<std::string> fields) {
  Commanded c;
  c.key = "module.walk.command.0";
  c.to = "motor";
  c.fields = std::move(fields);
  return c;
}
PolicyOptions options(std::vector<Observed> observed, std::vector<Commanded> commanded) {
  PolicyOptions o;
  o.name = "walk";
  o.observed = std::move(observed);
  o.commanded = std::move(commanded);
  return o;
}

/// A policy that sees the gyro's x as obs[0] and y as obs[1], and what it says and shows.
struct Walker {
  Walker(PolicyOptions o, const ModelWriter& network) : policy(std::move(o), file_of(network)), rig(policy) {
    rig.carries<msg::ImuSample>("in_imu_raw");
    rig.carries<msg::ActuatorCommand>("motor");
    rig.set("publish_vectors", true);
  }
  StepStatus step(double x, double y = 0) {
    msg::ImuSample sample;
    sample.stamp = now + stamp_off;
    sample.gyro_radps = {x, y, 0};
    rig.put("in_imu_raw", sample);
    return again();
  }
  /// A step without a new message.
  StepStatus again() {
    now = now + 10ms;
    return rig.step(now, 10ms);
  }
  std::vector<float> observed() const {
    const auto* v = rig.get<msg::PolicyVectors>("vectors");
    return v ? std::vector<float>(v->observation.begin(), v->observation.begin() + v->observed) : std::vector<float>();
  }
  double command(std::size_t channel = 0) const { return rig.get<msg::ActuatorCommand>("motor")->value[channel]; }
  msg::PolicyTopic topic() const { return rig.get<msg::PolicyState>("state")->topic[0]; }

  Policy policy;
  rt::ModuleRig rig;
  Time now{1'000'000'000};
  rt::Duration stamp_off = 7ms;
};

TEST(PolicyTest, FieldsAreScaledShiftedAndLimitedOnTheirWay) {
  Observed e = imu({"gyro_radps.x", "gyro_radps.y"});
  e.shaping = {{2, 1, -3, 3}, {0.5, 0, {}, {}}};
  Commanded c = motor({"value[1]"});
  c.index = 1;
  c.shaping = {{10, 0, -25, 25}};
  Walker w(options({e}, {c}), mirror(2));
  ASSERT_EQ(w.step(0.25, 4), StepStatus::ok);
  EXPECT_THAT(w.observed(), ElementsAre(1.5f, 2.0f));
  EXPECT_EQ(w.command(1), 20);
  ASSERT_EQ(w.step(8, 8), StepStatus::ok);
  EXPECT_THAT(w.observed(), ElementsAre(3.0f, 4.0f));
  EXPECT_EQ(w.command(1), 25);
  const auto* state = w.rig.get<msg::PolicyState>("state");
  EXPECT_EQ(state->clipped, 1u);
  EXPECT_EQ(state->clipped_commands, 1u);
}

TEST(PolicyTest, ACommandHasItsChannelsAndTheStampOfTheMeasurement) {
  Walker w(options({imu({"gyro_radps.x", "gyro_radps.y"})}, {motor({"value[0]", "value[2]"})}), mirror(2));
  ASSERT_EQ(w.step(0.25, 4), StepStatus::ok);
  const auto* command = w.rig.get<msg::ActuatorCommand>("motor");
  EXPECT_EQ(command->count, 3u);
  EXPECT_EQ(command->armed, 1u);
  EXPECT_EQ(command->stamp, w.now - 3ms);
}

TEST(PolicyTest, AHistoryOfAFieldIsOldestFirstAndBeginsWithTheFirstValue) {
  Observed e = imu({"gyro_radps.x"});
  e.history = 3;
  Walker w(options({e}, {motor({"value[0]"})}), mirror(3));
  ASSERT_EQ(w.step(1), StepStatus::ok);
  EXPECT_THAT(w.observed(), ElementsAre(1, 1, 1));
  w.step(2);
  w.step(3);
  EXPECT_THAT(w.observed(), ElementsAre(1, 2, 3));
  w.step(4);
  EXPECT_THAT(w.observed(), ElementsAre(2, 3, 4));
}

TEST(PolicyTest, AHistoryOfTheWholeObservationKeepsFieldsOfAStepTogether) {
  PolicyOptions o = options({imu({"gyro_radps.x"}), imu({"gyro_radps.y"})}, {motor({"value[0]"})});
  o.history = 2;
  o.newest_first = true;
  Walker w(o, mirror(4));
  w.step(1, 10);
  w.step(2, 20);
  EXPECT_THAT(w.observed(), ElementsAre(2, 20, 1, 10));
}

TEST(PolicyTest, AStepOfDelayCanBeAskedFor) {
  Observed now = imu({"gyro_radps.x"}), late = now;
  late.delay = 1;
  Commanded c = motor({"value[0]"});
  c.delay = 1;
  Walker w(options({now, late}, {c}), mirror(2));
  w.step(1);
  w.step(2);
  ASSERT_EQ(w.step(3), StepStatus::ok);
  EXPECT_THAT(w.observed(), ElementsAre(3, 2));
  EXPECT_EQ(w.command(), 2);
  EXPECT_EQ(w.rig.get<msg::PolicyState>("state")->delay, 1u);
}

TEST(PolicyTest, WhatItPutOutBeforeCanBeObserved) {
  Observed before, constant;
  before.output = "actions";
  constant.value = 0.5;
  Walker w(options({imu({"gyro_radps.x"}), before, constant}, {motor({"value[0]"})}), mirror(4));
  ASSERT_FALSE(w.rig.configure()) << "an output of 4 numbers is 4 numbers of the observation";
  ModelWriter m;
  m.input("obs", {1, 3})
      .output("actions", {1, 1})
      .weight("w", {3, 1}, {1, 2, 4})
      .node("MatMul", {"obs", "w"}, {"actions"});
  Walker v(options({imu({"gyro_radps.x"}), before, constant}, {motor({"value[0]"})}), m);
  v.step(1);
  EXPECT_THAT(v.observed(), ElementsAre(1, 0, 0.5));
  EXPECT_EQ(v.command(), 3);
  v.step(1);
  EXPECT_THAT(v.observed(), ElementsAre(1, 3, 0.5));
  EXPECT_EQ(v.command(), 9);
}

TEST(PolicyTest, ARecurrentValueGoesFromStepToStepUntilAReset) {
  PolicyOptions o = options({imu({"gyro_radps.x", "gyro_radps.y"})}, {motor({"value[0]"})});
  o.recurrent = {{"h", "h_out"}};
  Walker w(o, counter());
  w.step(1, 2);
  EXPECT_EQ(w.command(), 3);
  w.step(1, 2);
  EXPECT_EQ(w.command(), 6);
  w.rig.reset();
  w.step(1, 2);
  EXPECT_EQ(w.command(), 3);
}

TEST(PolicyTest, AStepThatFailsCommandsNothingAndLeavesNoTrace) {
  Observed e = imu({"gyro_radps.x"});
  e.history = 2;
  PolicyOptions o = options({e}, {motor({"value[0]"})});
  o.recurrent = {{"h", "h_out"}};
  Walker w(o, counter());
  EXPECT_EQ(w.again(), StepStatus::stale) << "no message yet";
  w.step(1);
  EXPECT_EQ(w.step(std::numeric_limits<double>::quiet_NaN()), StepStatus::fault);
  EXPECT_EQ(w.rig.get<msg::ActuatorCommand>("motor"), nullptr);
  w.step(2);
  EXPECT_THAT(w.observed(), ElementsAre(1, 2));
  EXPECT_EQ(w.command(), 2 + 3) << "1 + 1, and 1 + 2";
}

TEST(PolicyTest, AgesRepetitionsGapsAndReorderingAreShown) {
  Walker w(options({imu({"gyro_radps.x"})}, {motor({"value[0]"})}), mirror(1));
  w.step(1);
  EXPECT_EQ(w.topic().age_ns, 3'000'000);
  EXPECT_EQ(w.topic().arrived, 1u);
  w.again();
  EXPECT_EQ(w.topic().age_ns, 13'000'000);
  EXPECT_EQ(w.topic().arrived, 0u);
  EXPECT_EQ(w.topic().repeated, 1u);
  msg::ImuSample between;
  between.stamp = w.now;
  w.rig.put("in_imu_raw", between);
  w.step(1);
  EXPECT_EQ(w.topic().arrived, 2u);
  EXPECT_EQ(w.topic().skipped, 1u);
  EXPECT_EQ(w.topic().reordered, 0u);
  w.stamp_off = -20ms;
  w.step(1);
  EXPECT_EQ(w.topic().reordered, 1u);
}

std::string problems_of(PolicyOptions o, const ModelWriter& m) {
  Walker w(std::move(o), m);
  EXPECT_FALSE(w.rig.configure());
  std::string all;
  for (const rt::Problem& p : w.rig.problems()) all += p.value + ": " + p.allowed + "\n";
  return all;
}

TEST(PolicyTest, WhatDoesNotFitTheNetworkIsSaid) {
  EXPECT_THAT(problems_of(options({imu({"gyro_radps.x"})}, {motor({"value[0]"})}), mirror(3)),
              HasSubstr("1 number: as many as input 'obs' [1, 3] takes: 3 (observed: 1 number of imu.raw)"));
  EXPECT_THAT(problems_of(options({imu({"gyro.x"})}, {motor({"value[0]"})}), mirror(1)),
              HasSubstr("\"gyro.x\": a number of ImuSample: stamp gyro_radps.x"));
  EXPECT_THAT(problems_of(options({imu({"gyro_radps.x"})}, {motor({"value[0]", "value[1]"})}), mirror(1)),
              HasSubstr("0 and 2 fields: numbers within output 'actions' [1, 1]"));
  EXPECT_THAT(problems_of(options({imu({"gyro_radps.x"})}, {motor({"value[8]"})}), mirror(1)),
              HasSubstr("\"value[8]\": a number of ActuatorCommand"));
  PolicyOptions recurrent = options({imu({"gyro_radps.x", "gyro_radps.y"})}, {motor({"value[0]"})});
  recurrent.recurrent = {{"hidden", "h_out"}};
  EXPECT_THAT(problems_of(recurrent, counter()), HasSubstr("an input of the network in front of =: obs h"));
  ModelWriter unknown = mirror(1);
  unknown.node("Einsum", {"obs"}, {"e"}, {}, "/actor/Einsum");
  EXPECT_THAT(problems_of(options({imu({"gyro_radps.x"})}, {motor({"value[0]"})}), unknown),
              HasSubstr("node '/actor/Einsum' (Einsum): operator Einsum is not supported"));
}

}  // namespace
}  // namespace sinew::policy::policy_test
