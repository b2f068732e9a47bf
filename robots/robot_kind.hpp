#pragma once
// Sinew's robots: each is one folder here with its modules, its robot files and its world.
#include <span>
#include <string_view>
#include <vector>

#include "rt/module_types.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::robots {

/// The parts of a folder of robots/ for programs that run it. `robots/NAME/robot.cpp` defines `RobotKind
/// describe_NAME()`.
struct RobotKind {
  void (*add_modules)(rt::ModuleTypes&) = nullptr;  // its own module types; null: none
  plant::WorldInfo world{};                         // the devices in its world; without a name: no world
};

/// Of every folder, in the order of their names. The list is made by CMake (robots/CMakeLists.txt).
std::span<const RobotKind> all_robots();

/// The world of this name; null: no robot brings one.
const plant::WorldInfo* find_world(std::string_view name);
/// The names of all worlds.
std::vector<std::string> world_names();

/// One world and how it is made. `robots/NAME/world/` defines `plant::WorldType describe_world_of_NAME()`; all of them,
/// for a simulator. Not linked into robots.
std::vector<std::shared_ptr<const plant::WorldType>> all_worlds();

}  // namespace sinew::robots
