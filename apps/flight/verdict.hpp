#pragma once
#include <string>

#include "apps/flight/mission_watch.hpp"
#include "apps/robot_file/world_report.hpp"

namespace sinew::app {

/// What a run in a simulated world has come to.
struct RunVerdict {
  std::string outcome;  // in words; empty: there was nothing to judge
  bool good = false;
};

/// The world's word, and what the robot itself has to say to it: a mission that is not done, or a guardian that stopped
/// a robot without a mission, make a good run a bad one. A robot without a mission need not begin anything.
RunVerdict judge(const WorldReport& report, MissionWatch& mission);

}  // namespace sinew::app
