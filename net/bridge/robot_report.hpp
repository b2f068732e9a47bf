#pragma once
// What a robot's reply to `status` says to a ROS 2 graph.
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "net/ros2/system.hpp"

namespace sinew::net {

/// Turns replies to `status`, one after the other, into diagnostics and lines of the log.
/// Thread:  owner.   RT: no.
class RobotReport {
 public:
  struct Line {
    ros2::LogLevel level;
    std::string text;
  };
  struct Said {
    std::vector<ros2::Diagnosis> diagnostics;  // of all threads, modules, topics, the guardian and devices
    std::vector<Line> lines;                   // what is new since the reply before
  };
  /// `robot`: its name, the hardware_id. Anything that is no such reply gives one diagnosis that says so.
  Said read(std::string_view robot, std::string_view status);

 private:
  std::map<std::string, std::int64_t> counts_;  // of the reply before
  std::string mode_, action_, reasons_, complaints_;
};

}  // namespace sinew::net
