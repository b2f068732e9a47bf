#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "apps/run/plant_process.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// The options of `sinew team`. Where an option may begin with a robot, "ROBOT/", it is that robot's, else everybody's.
struct TeamRunOptions {
  std::vector<std::string> robots;  // paths of the robot files
  bool virtual_time = false;
  std::optional<std::uint64_t> seed;
  double rate = 1, duration_s = 0;
  std::vector<std::string> set;     // "ROBOT/module.param=value"
  std::vector<std::string> faults;  // "ROBOT/radio:off@5"
  std::vector<std::string> plant_args;
  std::string camera, record_folder;
  bool no_record = false, quiet = false, verbose = false, json = false;
};

/// One robot of the team, and how it is run.
struct TeamMember {
  std::string name;
  RobotFile robot;
  std::vector<std::string> arguments;  // of `sinew run`, without the plant's place
};

struct TeamSetup {
  std::vector<TeamMember> members;
  PlantRequest plant;
};

/// Loads and checks each robot as `sinew run` would, and all of them against each other. Nothing: it has printed why.
std::optional<TeamSetup> set_up_team(const TeamRunOptions& options, const rt::ModuleTypes& types);

/// What does not fit among robots of one world: names, worlds, cameras, options that they share, numbers in the team.
/// In words; empty: it fits.
std::string misfit(const std::vector<TeamMember>& members);

}  // namespace sinew::app
