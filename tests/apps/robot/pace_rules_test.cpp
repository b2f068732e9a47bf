// Time-outs that would run out without any fault are refused: the same robot file says how often something comes.
#include "apps/robot/pace_rules.hpp"

#include "../run/wired_head.hpp"

namespace sinew::app::pace_rules_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(PaceRules, ALeaseOutlivesThePauseBetweenTwoCommands) {
  EXPECT_THAT(problems({{"period_us = 1000", "period_us = 20000"}}),
              ElementsAre(at("[actuator.head]") + "actuator.head.lease_ms: 20: more than 20, the period of the thread "
                                                  "steer"));
  EXPECT_THAT(problems({{"period_us = 1000", "period_us = 19000"}}), IsEmpty());
}

TEST(PaceRules, ALeaseOutlivesATickOfTheBus) {
  EXPECT_THAT(problems({{"lease_ms = 20", "lease_ms = 2"}}),
              ElementsAre(at("[actuator.head]") + "actuator.head.lease_ms: 2: more than 2, as [bus.can0] has tick_hz "
                                                  "500"));
  EXPECT_THAT(problems({{"lease_ms = 20", "lease_ms = 2.1"}}), IsEmpty());
}

TEST(PaceRules, SilenceIsLongerThanThePauseBetweenTwoMessages) {
  const auto silent = [](const std::string& topic, const std::string& ms) {
    return problems({{"[bus.can0]", "[[failsafe]]\nname = \"lost\"\ntopic = \"" + topic + "\"\nsilent_ms = " + ms +
                                        "\naction = \"stop\"\n[bus.can0]"}});
  };
  EXPECT_THAT(silent("imu.raw", "1"),
              ElementsAre(HasSubstr("failsafe.lost.silent_ms: 1: more than 1, the period of the thread steer")));
  EXPECT_THAT(silent("imu.raw", "1.1"), IsEmpty());
  EXPECT_THAT(silent("joints.raw", "2"),
              ElementsAre(HasSubstr("failsafe.lost.silent_ms: 2: more than 2, as [bus.can0] has tick_hz 500")));
  EXPECT_THAT(
      silent("camera.raw", "33"),
      ElementsAre(HasSubstr("failsafe.lost.silent_ms: 33: more than 33.333333, as [device.camera] has rate_hz 30")));
  EXPECT_THAT(silent("camera.raw", "34"), IsEmpty());
}

}  // namespace
}  // namespace sinew::app::pace_rules_test
