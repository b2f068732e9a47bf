// Parameters of a running graph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "graph_fixture.hpp"
#include "test_modules.hpp"

namespace sinew::rt {
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
  Status step(const Step&) noexcept override {
    values.push_back(gain_);
    return Status::ok;
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
  EXPECT_EQ(refused("gain", "gian", 1.0), none + "gain has no parameter gian; it has: gain steps fast label");
  EXPECT_EQ(refused("gian", "gain", 1.0), none + "no module gian; there are: gain");
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
}  // namespace sinew::rt
