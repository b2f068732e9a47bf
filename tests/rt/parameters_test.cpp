// Parameters of a running graph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "graph_fixture.hpp"
#include "hal/board.hpp"
#include "rt/exec/step_again.hpp"
#include "test_modules.hpp"

namespace sinew::rt::parameters_test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

class Gain final : public Module {
 public:
  Gain() { values.reserve(1000); }
  void declare(Declaration& d) override {
    d.param("gain", gain_, {.unit = "rad", .min = 0.0, .max = 2.0});
    d.param("steps", steps_, {.min = 1});
    d.param("fast", fast_);
    d.param("label", label_);
  }
  StepStatus step(const Step&) noexcept override {
    values.push_back(gain_);
    return StepStatus::ok;
  }
  std::vector<double> values;

 private:
  double gain_ = 1.0;
  std::int64_t steps_ = 1;
  bool fast_ = false;
  std::string label_;
};

TEST(Parameters, ChangeBetweenTwoStepsAndTellWhich) {
  Robot robot;
  Gain& gain = robot.add<Gain>("gain");
  robot.module("gain").params["gain"] = {ParamValue(0.5), 3};
  robot.module("gain").exec.constant = 700us;
  robot.periodic("main", 10, 1ms, {"gain"});
  Graph& graph = robot.build();
  hal::Result<Ticket> ticket = hal::Error{};
  robot.grants.at(Time{1'300'000}, [&] {  // while the second step runs
    ticket = graph.set_param("gain", "gain", ParamValue(1.5));
    ASSERT_TRUE(ticket);
    EXPECT_EQ(graph.effect(*ticket), std::nullopt);
  });
  robot.run(3500us);
  EXPECT_THAT(gain.values, ElementsAre(0.5, 0.5, 1.5, 1.5));
  EXPECT_EQ(graph.effect(*ticket), Effect{2});
}

TEST(Parameters, AreRefusedOutsideTheirRangeWithTheReason) {
  Robot robot;
  Gain& gain = robot.add<Gain>("gain");
  robot.periodic("main", 10, 1ms, {"gain"});
  Graph& graph = robot.build();
  const auto refused = [&graph](const char* module, const char* name, const ParamValue& value) {
    std::string why;
    const auto ticket = graph.set_param(module, name, value, &why);
    EXPECT_FALSE(ticket) << name;
    return std::string(hal::to_string(ticket.error().code)) + ": " + why;
  };
  const std::string bad = std::string(hal::to_string(hal::Errc::bad_argument)) + ": ";
  const std::string none = std::string(hal::to_string(hal::Errc::not_found)) + ": ";
  EXPECT_EQ(refused("gain", "gain", 2.5), bad + "gain.gain: 2.5: a number from 0 to 2 rad");
  EXPECT_EQ(refused("gain", "gain", -0x1p-1074), bad + "gain.gain: -5e-324: a number from 0 to 2 rad");
  EXPECT_EQ(refused("gain", "gain", std::numeric_limits<double>::quiet_NaN()),
            bad + "gain.gain: nan: a number from 0 to 2 rad");
  EXPECT_EQ(refused("gain", "gain", true), bad + "gain.gain: true: a number from 0 to 2 rad");
  EXPECT_EQ(refused("gain", "steps", std::int64_t{0}), bad + "gain.steps: 0: an integer from 1 up");
  EXPECT_EQ(refused("gain", "steps", 1.0), bad + "gain.steps: 1: an integer from 1 up");
  EXPECT_EQ(refused("gain", "fast", std::int64_t{1}), bad + "gain.fast: 1: true or false");
  EXPECT_EQ(refused("gain", "gian", 1.0),
            none + "gain has no parameter gian; it has: gain steps fast label; did you mean gain?");
  EXPECT_EQ(refused("gian", "gain", 1.0), none + "no module gian; there are: gain; did you mean gain?");
  EXPECT_EQ(refused("gain", "label", std::string("x")),
            std::string(hal::to_string(hal::Errc::not_supported)) + ": a text is set before the start only");
  robot.run(1500us);
  EXPECT_THAT(gain.values, Each(1.0));
}

TEST(Parameters, TheLimitsThemselvesAndIntegersAreNumbers) {
  Robot robot;
  Gain& gain = robot.add<Gain>("gain");
  robot.periodic("main", 10, 1ms, {"gain"});
  Graph& graph = robot.build();
  robot.grants.at(Time{500'000}, [&] { EXPECT_TRUE(graph.set_param("gain", "gain", ParamValue(0.0))); });
  robot.grants.at(Time{1'500'000}, [&] { EXPECT_TRUE(graph.set_param("gain", "gain", ParamValue(std::int64_t{2}))); });
  robot.run(2500us);
  EXPECT_THAT(gain.values, ElementsAre(1.0, 0.0, 2.0));
}

/// Has a device that allows less than what is declared, or says that there is nothing to set.
class Lens final : public Module {
 public:
  Lens() { zooms.reserve(100); }
  void declare(Declaration& d) override {
    d.param("zoom", zoom_, {.unit = "mm", .min = -1, .max = 1000});
    d.param("stop", stop_, {.min = 0, .max = 22});
  }
  hal::Status configure(Setup& setup) override {
    const auto zoom = setup.narrow("zoom", device_zoom);
    const auto stop = setup.narrow("stop", device_stop);
    return zoom ? stop : zoom;
  }
  StepStatus step(const Step&) noexcept override {
    zooms.push_back(zoom_);
    return StepStatus::ok;
  }
  ParamRange device_zoom{24, 70, -1, "control 'zoom' of device 'eye'"};
  ParamRange device_stop{0, 0, {}, "device 'eye' has no stop"};
  std::vector<double> zooms;

 private:
  double zoom_ = -1;
  std::int64_t stop_ = 0;
};

/// What set_param() says; empty: it was accepted.
std::string refusal(Graph& graph, const char* name, const ParamValue& value) {
  std::string why;
  const auto ticket = graph.set_param("lens", name, value, &why);
  if (!ticket) {
    EXPECT_EQ(ticket.error().code, hal::Errc::bad_argument);
  }
  return why;
}

TEST(ParametersNarrowed, OnlyWhatTheDeviceAllowsIsAcceptedAndTheRefusalSaysWhoseRangeItIs) {
  Robot robot;
  Lens& lens = robot.add<Lens>("lens");
  robot.periodic("main", 10, 1ms, {"lens"});
  Graph& graph = robot.build();
  const std::string allowed = ": a number from 24 to 70 mm, or -1: control 'zoom' of device 'eye'";
  EXPECT_EQ(refusal(graph, "zoom", 71.0), "lens.zoom: 71" + allowed);
  EXPECT_EQ(refusal(graph, "zoom", 0.0), "lens.zoom: 0" + allowed) << "the declaration alone would take it";
  EXPECT_EQ(refusal(graph, "zoom", 2000.0), "lens.zoom: 2000" + allowed) << "what is left, not what was declared";
  EXPECT_EQ(refusal(graph, "zoom", std::numeric_limits<double>::quiet_NaN()), "lens.zoom: nan" + allowed);
  EXPECT_EQ(refusal(graph, "stop", std::int64_t{8}), "lens.stop: 8: only 0: device 'eye' has no stop");
  EXPECT_EQ(refusal(graph, "stop", std::int64_t{0}), "");
  robot.grants.at(Time{500'000}, [&] { EXPECT_EQ(refusal(graph, "zoom", 24.0), ""); });
  robot.grants.at(Time{1'500'000}, [&] { EXPECT_EQ(refusal(graph, "zoom", std::int64_t{70}), ""); });
  robot.grants.at(Time{2'500'000}, [&] { EXPECT_EQ(refusal(graph, "zoom", -1.0), ""); });
  robot.run(3500us);
  EXPECT_THAT(lens.zooms, ElementsAre(-1.0, 24.0, 70.0, -1.0));
}

TEST(ParametersNarrowed, WhatTheRobotFileSaysIsHeldAgainstTheDeviceToo) {
  Robot robot;
  robot.add<Lens>("lens");
  robot.module("lens").params["zoom"] = {ParamValue(20.0), 7};
  robot.module("lens").params["stop"] = {ParamValue(std::int64_t{8}), 8};
  robot.periodic("main", 10, 1ms, {"lens"});
  Graph graph(robot.spec, robot.types);
  ASSERT_TRUE(graph.check({.virtual_time = true}).empty());
  hal::EmptyBoard board;
  const auto configured = graph.configure(board);
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, hal::Errc::bad_argument);
  std::vector<std::string> problems;
  for (const Problem& p : graph.configure_problems()) problems.push_back(to_string(p, "r.toml"));
  EXPECT_THAT(problems, ElementsAre("r.toml:7: module.lens.params.zoom: 20: a number from 24 to 70 mm, or -1: control "
                                    "'zoom' of device 'eye'",
                                    "r.toml:8: module.lens.params.stop: 8: only 0: device 'eye' has no stop"));
}

TEST(ParametersNarrowed, RangeOfTheDeviceNeverWidensTheDeclaredOne) {
  const auto left = [](ParamRange device) {
    Robot robot;
    robot.add<Lens>("lens").device_zoom = std::move(device);
    robot.periodic("main", 10, 1ms, {"lens"});
    return refusal(robot.build(), "zoom", 1e6);
  };
  EXPECT_EQ(left({-50, 5000, -1, "x"}), "lens.zoom: 1e+06: a number from -1 to 1000 mm: x");
  EXPECT_EQ(left({2000, 3000, -1, "x"}), "lens.zoom: 1e+06: only -1: x") << "nothing in common";
}

TEST(ParametersNarrowed, ConfiguredAgainTheRangeIsThatOfTheLastTime) {
  Robot robot;
  Lens& lens = robot.add<Lens>("lens");
  robot.periodic("main", 10, 1ms, {"lens"});
  Graph& graph = robot.build();
  lens.device_zoom = {-1, 300, {}, "another eye"};
  hal::EmptyBoard board;
  ASSERT_TRUE(graph.configure(board));
  EXPECT_EQ(refusal(graph, "zoom", 299.0), "");
  EXPECT_EQ(refusal(graph, "zoom", 301.0), "lens.zoom: 301: a number from -1 to 300 mm: another eye");
}

TEST(ParametersNarrowed, DeclarationStaysSoThatARecordIsExecutedAgainWithoutTheDevice) {
  Robot run;
  run.add<Lens>("lens").device_zoom = {-1, 5000, {}, "a longer eye"};
  run.periodic("main", 10, 1ms, {"lens"});
  Graph& graph = run.build();
  EXPECT_EQ(refusal(graph, "zoom", 900.0), "");
  Robot other;  // with a device that allows less
  other.add<Lens>("lens");
  other.periodic("main", 10, 1ms, {"lens"});
  StepAgain again(other.build(), 0);
  Request request;
  request.value = 900.0;
  EXPECT_TRUE(again.take(request, Effect{1})) << "a record holds what was allowed then";
  request.value = 1001.0;
  EXPECT_FALSE(again.take(request, Effect{1})) << "no run could have had that";
}

TEST(Parameters, AFullMailboxRefusesAndLosesNothing) {
  Robot robot;
  Gain& gain = robot.add<Gain>("gain");
  robot.periodic("main", 10, 1ms, {"gain"});
  Graph& graph = robot.build();
  int accepted = 0;
  while (graph.set_param("gain", "gain", ParamValue(accepted * 0x1p-7))) ++accepted;
  EXPECT_EQ(graph.set_param("gain", "gain", ParamValue(1.0)).error().code, hal::Errc::busy);
  robot.run(500us);
  EXPECT_EQ(accepted, 64);
  EXPECT_THAT(gain.values, ElementsAre(63 * 0x1p-7));
}

}  // namespace
}  // namespace sinew::rt::parameters_test
