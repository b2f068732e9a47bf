#pragma once
// One case flown in virtual time, and what came out of it.
#include <map>
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "apps/search/exec_profile.hpp"
#include "apps/search/flight_check.hpp"

namespace sinew::search {

/// How a flight ended. Without a position a landing drifts, in the end to the wall of the room; open air has no wall.
enum class Ending : std::uint8_t { landed_on_pad, landed_elsewhere, at_the_wall, did_not_fly, fell, crashed, not_over };
const char* to_string(Ending ending);

struct Outcome {
  std::optional<Violation> violation;
  Ending ending = Ending::not_over;
  double ended_s = 0;  // virtual time
  double landing_error_m = 0, touchdown_speed_mps = 0;
  Worst worst;
  std::map<std::string, double> worst_age_ms;                     // per chain
  std::uint64_t steps = 0, overruns = 0, commands = 0, hash = 0;  // hash: of all topics
};

/// Processor time of every step, by module.
using ExecSamples = std::map<std::string, std::vector<rt::Duration>>;

struct FlightSettings {
  app::RobotFile robot;
  ExecProfile profile;
  Limits limits;
  ExecSamples* measured = nullptr;  // not null: execution times are measured instead of drawn, and added here
};

/// Starts a plant, flies, and checks the flight at every instant that the plant grants.
/// Errors:  nothing, with the reason in `why`: no plant, a robot file that does not fit; such a case says nothing about
///          the robot.
std::optional<Outcome> fly(const FlightSettings& settings, const Case& c, std::string& why);

}  // namespace sinew::search
