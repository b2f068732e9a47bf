// The texts that the commands for running robots make of a robot's answers, without a robot.
#include <gmock/gmock.h>

#include "apps/completion.hpp"
#include "apps/live/status_text.hpp"
#include "apps/live/topic_rate.hpp"
#include "apps/module_list.hpp"
#include "apps/robot_file/param_overlay.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/run/device_watch.hpp"
#include "apps/view/message_text.hpp"
#include "source_dir.hpp"

namespace sinew::app::live_text_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

TEST(RateMeter, GivesRateJitterAndLossesFromSequenceNumbersAcrossTheirWrap) {
  RateMeter meter;
  meter.add(0xFFFFFFFE, {0});
  meter.add(0xFFFFFFFF, {1'000'000});
  meter.add(0, {2'100'000});  // 100 us late
  meter.add(1, {3'000'000});  // hence 100 us early
  meter.add(4, {6'000'000});  // two are lost
  const TopicRate r = meter.result();
  EXPECT_EQ(r.messages, 5u);
  EXPECT_EQ(r.lost, 2u);
  EXPECT_DOUBLE_EQ(r.rate_hz, 1000) << "lost messages were published, too";
  EXPECT_EQ(r.interval_p50, 1ms);
  EXPECT_EQ(r.interval_max, 1100us) << "an interval over a loss is none";
  EXPECT_EQ(r.jitter_p50, 100us);
  EXPECT_EQ(r.jitter_p99, 100us);
}

TEST(RateMeter, OfOneMessageThereIsNoRate) {
  RateMeter meter;
  EXPECT_EQ(meter.result().messages, 0u);
  meter.add(7, {5});
  EXPECT_EQ(meter.result().rate_hz, 0);
  EXPECT_EQ(meter.result().messages, 1u);
}

TEST(MessageText, IndentsWhatIsNestedAndKeepsArraysOnALine) {
  EXPECT_EQ(indented_text(Json::parse(R"({"stamp": 5, "p_m": {"x": 1.5, "y": "NaN"}, "value": [1, 2]})")),
            "stamp: 5\np_m:\n  x: 1.5\n  y: NaN\nvalue: [1,2]\n");
}

TEST(MessageText, FindsFieldsByPathAndNamesTheChoicesElse) {
  const Json message = Json::parse(R"({"stamp": 5, "p_m": {"x": 1.5, "y": 2}, "value": [7, 8]})");
  std::string why;
  EXPECT_EQ(*find_field(message, "p_m.x", why), 1.5);
  EXPECT_EQ(*find_field(message, "value.1", why), 8);
  EXPECT_EQ(find_field(message, "p_m.z", why), nullptr);
  EXPECT_EQ(why, "p_m.z: no \"z\"; one of x y");
  EXPECT_EQ(find_field(message, "value.2", why), nullptr);
  EXPECT_EQ(why, "value.2: no \"2\"; an index from 0 to 1");
  EXPECT_EQ(find_field(message, "stamp.x", why), nullptr);
  EXPECT_EQ(why, "stamp.x: no \"x\"; there is nothing inside it");
  EXPECT_EQ(find_field(message, "", why), nullptr);
}

class Overlay : public ::testing::Test {
 protected:
  rt::GraphSpec graph = load_robot(sinew::test::source_dir() + "/robots/quad/quad.toml").robot.graph;
  std::vector<std::string> problems(std::string_view text) {
    std::vector<std::string> all;
    for (const auto& p : apply_overlay(parse_overlay(text, "p.toml"), all_modules(), graph))
      all.push_back(rt::to_string(p, "p.toml"));
    return all;
  }
  rt::ParamValue value(const std::string& module, const std::string& param) {
    for (const auto& m : graph.modules)
      if (m.name == module) return m.params.at(param).value;
    return "no such module";
  }
};

TEST_F(Overlay, TakesThePlaceOfTheRobotFilesValues) {
  EXPECT_THAT(problems("[mixer]\nthrust_max_n = 5.5\n[mission]\nretries = 1\n"), IsEmpty());
  EXPECT_EQ(value("mixer", "thrust_max_n"), rt::ParamValue(5.5));
  EXPECT_EQ(value("mission", "retries"), rt::ParamValue(std::int64_t{1}));
}

TEST_F(Overlay, EveryProblemIsNamedWithItsLine) {
  EXPECT_THAT(problems("[nobody]\nx = 1\n[mixer]\nthrust_max_n = -1.0\nwings = 2\narm_x_m = [1]\n"),
              ElementsAre("p.toml:6: mixer.arm_x_m: [ 1 ]: a boolean, a number or a string",
                          "p.toml:2: nobody.x: 1: no module nobody in the robot file",
                          HasSubstr("p.toml:4: mixer.thrust_max_n: -1: a number from"),
                          "p.toml:5: mixer.wings: 2: no such parameter of control::Mixer"));
  EXPECT_EQ(value("mixer", "thrust_max_n"), rt::ParamValue(6.0)) << "what does not fit is not taken";
  EXPECT_THAT(problems("mixer = 3\n"), ElementsAre("p.toml:1: mixer: 3: [MODULE] with its parameters"));
  EXPECT_THAT(problems("[mixer\n"), ElementsAre(HasSubstr("p.toml:1: TOML: syntax")));
  EXPECT_EQ(load_overlay("no_such.toml").problems.size(), 1u);
}

TEST_F(Overlay, WhatIsWrittenReadsBackWithTheSameValuesAndTypes) {
  const std::vector<OverlayParam> params{{"a", "real", 2.0, 0},
                                         {"a", "tiny", 1e-300, 0},
                                         {"a", "count", std::int64_t{-3}, 0},
                                         {"b", "on", true, 0},
                                         {"b", "text", "say \"\\\"\n", 0}};
  const ParamOverlay back = parse_overlay(overlay_text("quad", params), "p.toml");
  ASSERT_THAT(back.problems, IsEmpty());
  ASSERT_EQ(back.params.size(), params.size());
  for (std::size_t i = 0; i < params.size(); ++i) {
    EXPECT_EQ(back.params[i].module + "." + back.params[i].param, params[i].module + "." + params[i].param);
    EXPECT_EQ(back.params[i].value, params[i].value) << params[i].param;
  }
}

TEST(StatusText, NamesWhatNeedsAttention) {
  const std::string text = status_text(Json::parse(R"({
      "robot": "quad", "pid": 12, "board": "sim", "virtual_time": false,
      "threads": [{"name": "fast", "overruns": 0}, {"name": "slow", "overruns": 3}],
      "modules": [{"name": "a", "running": true, "fault": 2, "stops": 0},
                  {"name": "b", "running": false, "fault": 10, "stops": 1},
                  {"name": "c", "running": false, "fault": 0, "stops": 0}],
      "topics": [{"name": "a.x", "drops": 0}],
      "guardian": {"mode": 0, "permitted": 0, "ready": 0, "reasons": ["battery_low: 13.1 V", "motors: no command"]}})"));
  EXPECT_THAT(text, HasSubstr("robot     quad: process 12, board sim, real time\n"));
  EXPECT_THAT(text, HasSubstr("threads   2; with overruns: slow\n"));
  EXPECT_THAT(text, HasSubstr("modules   3; stopped: b; disabled: c; with faults: a, b\n"));
  EXPECT_THAT(text, HasSubstr("topics    1; with losses: none\n"));
  EXPECT_THAT(text,
              HasSubstr("standby; commands do not pass; not ready:\n          battery_low: 13.1 V\n          motors"));
}

TEST(StatusText, HasWhatDevicesComplainAbout) {
  EXPECT_THAT(status_text(Json::parse(R"({"devices": {"complaints": ["bus 'can0': bus-off", "imu: silent"]}})")),
              HasSubstr("devices   complain:\n          bus 'can0': bus-off\n          imu: silent\n"));
  EXPECT_THAT(status_text(Json::parse(R"({"devices": {"complaints": []}})")),
              HasSubstr("devices   nothing to complain about\n"));
  EXPECT_THAT(status_text(Json::parse(R"({"devices": 3})")), HasSubstr("devices   nothing"));
  EXPECT_THAT(status_text(Json::parse("{}")), ::testing::Not(HasSubstr("devices")));
}

TEST(DeviceWatch, SaysWhatComesAndGoesOnceAndRemembersItForTheEnd) {
  std::vector<std::string> now{"bus 'can0': down"};
  DeviceWatch watch([&] { return now; }, {"bus 'can0': down"});
  const auto at = [](double s) { return hal::Time{static_cast<std::int64_t>(s * 1e9)}; };
  EXPECT_THAT(watch.look(at(1)), IsEmpty()) << "was said when it was opened";
  now.push_back("imu: silent");
  EXPECT_THAT(watch.look(at(1.2)), ElementsAre("imu: silent"));
  EXPECT_THAT(watch.look(at(1.4)), IsEmpty()) << "no news";
  now = {"bus 'can0': down"};
  EXPECT_THAT(watch.look(at(1.6)), IsEmpty()) << "it may come back";
  EXPECT_THAT(watch.now(), ElementsAre("bus 'can0': down", "imu: silent"));
  EXPECT_THAT(watch.look(at(3.4)), ElementsAre("over after 0.2 s: imu: silent"));
  EXPECT_THAT(watch.now(), ElementsAre("bus 'can0': down"));
  now.push_back("imu: silent");
  EXPECT_THAT(watch.look(at(5)), ElementsAre("imu: silent"));
  EXPECT_THAT(watch.look(at(6)), IsEmpty());
  EXPECT_THAT(watch.all(),
              ElementsAre("bus 'can0': down (5.0 s, to the end)", "imu: silent (2 times, 1.2 s, to the end)"));
}

TEST(StatusText, AReplyOfAnotherKindIsNoCrash) {
  for (const char* text :
       {"{}", R"({"threads": 3, "modules": [1, "x", {"exec": []}], "topics": [{"age": {"p99_ns": -1}}]})",
        R"({"guardian": [], "outsiders": 4, "chains": [{"age": "old"}]})"}) {
    const Json status = Json::parse(text);
    EXPECT_FALSE(status_text(status).empty());
    EXPECT_FALSE(module_table(status).empty());
    rows_of(status);
  }
}

}  // namespace
}  // namespace sinew::app::live_text_test
