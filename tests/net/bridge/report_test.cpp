#include "net/bridge/robot_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sinew::net {
namespace {

using ros2::Health;
using testing::HasSubstr;

std::string status(int overruns, int faults, const char* mode, const char* running = "true") {
  return R"({"threads":[{"name":"control","overruns":)" + std::to_string(overruns) +
         R"(,"completions":9,"lateness":{"p99_ns":1500000},"exec":{}}],"modules":[{"name":"rate","running":)" +
         running + R"(,"steps":5,"stale":0,"fault":)" + std::to_string(faults) +
         R"(}],"topics":[{"name":"imu.raw","messages":3,"drops":0}],"guardian":{"mode":)" + mode +
         R"(,"action":0,"reasons":[]},"devices":{"complaints":""}})";
}

const ros2::Diagnosis& find(const RobotReport::Said& said, std::string_view name) {
  for (const ros2::Diagnosis& d : said.diagnostics)
    if (d.name == name) return d;
  static const ros2::Diagnosis kNone;
  ADD_FAILURE() << name;
  return kNone;
}

TEST(RobotReport, WhatRoseSinceTheLastReportIsAWarning) {
  RobotReport report;
  const auto first = report.read("quad", status(7, 0, "0"));
  EXPECT_EQ(find(first, "thread control").health, Health::ok) << "what was before is not new";
  EXPECT_EQ(find(first, "thread control").values[2], (std::pair<std::string, std::string>("lateness p99", "1.500 ms")));
  const auto second = report.read("quad", status(9, 2, "2"));
  EXPECT_EQ(find(second, "thread control").health, Health::warn);
  EXPECT_EQ(find(second, "thread control").message, "2 overruns since the last report");
  EXPECT_EQ(find(second, "module rate").health, Health::error);
  ASSERT_EQ(second.lines.size(), 1U);
  EXPECT_EQ(second.lines[0].text, "guardian: standby -> active");
  EXPECT_EQ(find(report.read("quad", status(9, 2, "2", "false")), "module rate").health, Health::error);
}

TEST(RobotReport, WhatIsNoStatusIsSaid) {
  RobotReport report;
  for (const char* text : {"", "[]", "{}", "{\"threads\":3", "null"})
    EXPECT_EQ(report.read("quad", text).diagnostics[0].message, "its reply to status is none") << text;
  EXPECT_TRUE(
      report.read("quad", R"({"threads":3,"modules":"x","topics":[1],"guardian":7,"devices":[]})").lines.empty());
}

}  // namespace
}  // namespace sinew::net
