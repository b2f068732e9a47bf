#include "apps/replay/swept_params.hpp"

#include <gmock/gmock.h>

#include "rt/module.hpp"

namespace sinew::app::swept_params_test {
namespace {

using rt::ParamValue;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Filter final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.param("gain", gain_, {.unit = "1", .min = 0, .max = 10});
    d.param("taps", taps_, {.min = 1, .max = 8});
    d.param("mode", mode_);
    d.param("on", on_);
  }
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }

 private:
  double gain_ = 1;
  std::int64_t taps_ = 2;
  std::string mode_ = "a";
  bool on_ = true;
};

class SweepTest : public ::testing::Test {
 protected:
  SweepTest() {
    types_.add<Filter>("test::Filter");
    rt::ModuleSpec m;
    m.name = "filter";
    m.type = "test::Filter";
    spec_.modules.push_back(m);
    graph_ = std::make_unique<rt::Graph>(spec_, types_);
  }
  std::vector<ParamValue> values(const std::string& text) {
    std::string why;
    const auto swept = parse_sweep(text, *graph_, why);
    EXPECT_TRUE(swept) << why;
    return swept ? swept->values : std::vector<ParamValue>{};
  }
  std::string refusal(const std::string& text) {
    std::string why;
    EXPECT_FALSE(parse_sweep(text, *graph_, why)) << text;
    return why;
  }
  rt::ModuleTypes types_;
  rt::GraphSpec spec_;
  std::unique_ptr<rt::Graph> graph_;
};

TEST_F(SweepTest, ARangeHasBothEndsAndEvenSteps) {
  EXPECT_THAT(values("filter.gain=0.2:2:4"),
              ElementsAre(ParamValue(0.2), ParamValue(0.8), ParamValue(1.4), ParamValue(2.0)));
  EXPECT_THAT(values("filter.gain=5:1:3"), ElementsAre(ParamValue(5.0), ParamValue(3.0), ParamValue(1.0)));
  EXPECT_THAT(values("filter.gain=3:9:1"), ElementsAre(ParamValue(3.0)));
}

TEST_F(SweepTest, ALogarithmicRangeHasEvenFactors) {
  EXPECT_THAT(values("filter.gain=0.001:10:5:log"),
              ElementsAre(ParamValue(0.001), ParamValue(0.01), ParamValue(0.1), ParamValue(1.0), ParamValue(10.0)));
}

TEST_F(SweepTest, IntegersStayIntegersAndStandOnce) {
  const auto one = ParamValue(std::int64_t{1}), two = ParamValue(std::int64_t{2}), three = ParamValue(std::int64_t{3});
  EXPECT_THAT(values("filter.taps=1:3:7"), ElementsAre(one, two, three));
  EXPECT_THAT(values("filter.taps=2,3,2"), ElementsAre(two, three));
}

TEST_F(SweepTest, ListsTakeWhateverTheParameterIs) {
  EXPECT_THAT(values("filter.on=true,false"), ElementsAre(ParamValue(true), ParamValue(false)));
  EXPECT_THAT(values("filter.mode=fast,slow:er"), ElementsAre(ParamValue("fast"), ParamValue("slow:er")));
}

TEST_F(SweepTest, WhatIsWrongIsNamedWithWhatIsAllowed) {
  EXPECT_THAT(refusal("gain=1"), HasSubstr("MODULE.PARAM=FROM:TO:COUNT"));
  EXPECT_THAT(refusal("nobody.gain=1"), HasSubstr("no module nobody; there are: filter"));
  EXPECT_THAT(refusal("filter.gian=1"),
              HasSubstr("no parameter gian; it has: gain, taps, mode, on; did you mean gain?"));
  EXPECT_THAT(refusal("filter.gain=1:11:3"), HasSubstr("11: a number from 0 to 10"));
  EXPECT_THAT(refusal("filter.gain=fast"), HasSubstr("\"fast\": a number from 0 to 10"));
  EXPECT_THAT(refusal("filter.gain=0:1:3:log"), HasSubstr("above 0"));
  EXPECT_THAT(refusal("filter.gain=0:1:2.5"), HasSubstr("\"2.5\": a count"));
  EXPECT_THAT(refusal("filter.gain=0:1:0"), HasSubstr("\"0\": a count"));
  EXPECT_THAT(refusal("filter.gain=0:nan:3"), HasSubstr("MODULE.PARAM=FROM:TO:COUNT"));
  EXPECT_THAT(refusal("filter.taps=0.5,1"), HasSubstr("0.5: an integer from 1 to 8"));
  EXPECT_THAT(refusal("filter.on=true:false:2"), HasSubstr("MODULE.PARAM=FROM:TO:COUNT"));
}

TEST_F(SweepTest, TheGridHasEveryCombination) {
  const std::vector<SweptParam> params{{"filter", "gain", {1.0, 2.0}}, {"filter", "on", {true, false}}};
  const auto points = grid(params);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_THAT(points[1], ElementsAre(ParamValue(1.0), ParamValue(false)));
  EXPECT_THAT(points[2], ElementsAre(ParamValue(2.0), ParamValue(true)));
  apply(params, points[2], spec_);
  EXPECT_EQ(spec_.modules[0].params.at("gain").value, ParamValue(2.0));
}

}  // namespace
}  // namespace sinew::app::swept_params_test
