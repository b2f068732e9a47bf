#pragma once
// The robots of this house: each is one folder here, which brings its modules, its robot files and its world.
#include <span>
#include <string_view>
#include <vector>

#include "rt/module_types.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::robots {

/// What a folder of robots/ brings to programs that run it. `robots/NAME/robot.cpp` defines `RobotKind
/// describe_NAME()`.
struct RobotKind {
  void (*add_modules)(rt::ModuleTypes&) = nullptr;  // its own module types; null: none
  plant::WorldInfo world{};                         // what there is on board in its world; without a name: it has none
};

/// Of every folder, in the order of their names. The list is made by CMake (robots/CMakeLists.txt).
std::span<const RobotKind> all_robots();

/// The world of this name; null: no robot brings one.
const plant::WorldInfo* find_world(std::string_view name);
/// The names of all worlds, quoted, for messages: "desk_head", "quad".
std::string world_names();

/// One world and how it is made. `robots/NAME/world/` defines `plant::WorldType describe_world_of_NAME()`; all of them,
/// for a simulator. Not linked into robots.
std::vector<std::shared_ptr<const plant::WorldType>> all_worlds();

}  // namespace sinew::robots
