// [ros2] against the robot's topics and their types: each problem with its line.
#include "apps/robot/ros2_rules.hpp"

#include <gmock/gmock.h>

#include "../run/wired_head.hpp"

namespace sinew::app::ros2_rules_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kHead = R"([ros2]
distro = "humble"
[[ros2.out]]
from = "imu.raw"
topic = "imu"
type = "sensor_msgs/msg/Imu"
frame = "head"
)";

/// What is wrong with the head when it has this table; its lines are counted from [ros2].
std::vector<std::string> with(const std::string& ros2) {
  const std::string whole = ros2 + "[bus.can0]";
  std::vector<std::string> all = problems({{"[bus.can0]", whole}});
  for (std::string& one : all) {
    const int line = std::stoi(one.substr(7)), first = std::stoi(at("[bus.can0]").substr(7));
    one = std::to_string(line - first + 1) + one.substr(one.find(':', 7));
  }
  return all;
}
std::string changed_head(const std::string& from, const std::string& to) {
  std::string text = kHead;
  return text.replace(text.find(from), from.size(), to);
}

TEST(Ros2Rules, ATableThatFitsTheRobotHasNoProblem) { EXPECT_THAT(with(kHead), IsEmpty()); }

TEST(Ros2Rules, ATopicThatTheRobotDoesNotHaveIsNamedWithTheOneThatItResembles) {
  EXPECT_THAT(with(changed_head("imu.raw", "imu.row")),
              ElementsAre(testing::AllOf(HasSubstr("3: ros2.out.0.from: \"imu.row\": a topic of this robot"),
                                         HasSubstr("did you mean imu.raw?"))));
}

TEST(Ros2Rules, TypesHaveToFitTheTopic) {
  EXPECT_THAT(
      with(changed_head("sensor_msgs/msg/Imu", "sensor_msgs/msg/MagneticField")),
      ElementsAre(
          "3: ros2.out.0: sensor_msgs/msg/MagneticField of \"imu.raw\": goes with messages of MagSample, and the "
          "topic's are ImuSample"));
  EXPECT_THAT(with(changed_head("msg/Imu", "msg/Imo")), ElementsAre(HasSubstr("did you mean sensor_msgs/msg/Imu?")));
  EXPECT_THAT(with(changed_head("sensor_msgs/msg/Imu", "sinew_msgs/msg/ImuSample")), IsEmpty());
  EXPECT_THAT(with(changed_head("frame = \"head\"\n", "")), ElementsAre(HasSubstr("frame is required")));
  EXPECT_THAT(with(changed_head("sensor_msgs/msg/Imu\"", "std_msgs/msg/Float64\"\nfield = \"gyro_radps.w\"")),
              ElementsAre(HasSubstr("field names a number of ImuSample")));
}

TEST(Ros2Rules, WhatComesInNeedsATopicFromOutside) {
  const std::string in =
      "[[ros2.in]]\nto = \"imu.raw\"\ntopic = \"imu\"\ntype = \"sensor_msgs/msg/Imu\"\nframe = \"head\"\n";
  EXPECT_THAT(with(kHead + in),
              ElementsAre("8: ros2.in.0.to: \"imu.raw\": a topic with writer = \"external\", of which there is none"));
}

}  // namespace
}  // namespace sinew::app::ros2_rules_test
