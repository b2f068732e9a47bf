#pragma once
// What a world lets its user choose, in a robot file's [sim] and by --set sim.KEY=VALUE. Each world has the table of
// its own options: WorldInfo::options in robots/NAME/devices.hpp.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

class TomlReader;

/// Reads the keys of [sim] that the world of `sim` offers, and `seed`. A key of another world is a problem of its own.
void read_world_options(TomlReader& r, SimTable& sim);

/// Applies "sim.KEY=VALUE", KEY being an option of the world or `seed`; returns the reason on failure, empty when
/// applied. Nothing, without any change: the setting does not begin with "sim.".
std::optional<std::string> apply_sim_setting(SimTable& sim, const std::string& setting);

/// Seed of the world: its own, or else the robot's.
std::uint64_t world_seed(const RobotFile& robot);

/// The options as sinew-sim takes them: "--gust=3".
std::vector<std::string> world_arguments(const SimTable& sim);

/// What this world is made with, in words by key: each of its options as `arguments` for sinew-sim say ("--gust=3", the
/// last one counts), as the table says, or else its default; and `seed` where the arguments say it.
std::map<std::string, std::string> world_choices(const SimTable& sim, const std::vector<std::string>& arguments);

/// "sim.gust_mps=" and all others of this world, for the shell; of an unknown world those of all.
std::vector<std::string> world_settings(const std::string& world);

}  // namespace sinew::app
