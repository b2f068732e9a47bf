#pragma once
#include <string>

#include "apps/flight/mission_watch.hpp"
#include "apps/robot_file/world_report.hpp"

namespace sinew::app {

/// The verdict on a run in a simulated world.
struct RunVerdict {
  std::string outcome;  // in words; empty: there was nothing to judge
  bool good = false;
};

/// The world's verdict, with the robot's own state: a good run becomes a bad one if the mission is not done, or if the
/// guardian stopped a robot without a mission. A robot without a mission need not begin anything.
RunVerdict judge(const WorldReport& report, MissionWatch& mission);

}  // namespace sinew::app
