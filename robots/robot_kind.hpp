#pragma once
// Sinew's robots: each is one folder here with its modules, its robot files and its world.
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "msg/flight.hpp"
#include "rt/module_types.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::motion {
struct MotionBook;
}

namespace sinew::robots {

/// What a robot file says of the robot's body ([body]) and of its motions ([motions]); null: nothing.
struct RobotBody {
  std::shared_ptr<const kinematics::Body> body{};
  std::shared_ptr<const motion::MotionBook> motions{};
};

/// A module type that has to know the robot's body. Without one it can be declared, and says in configure() that it
/// needs one.
struct BodyModule {
  std::string_view type;
  std::unique_ptr<rt::Module> (*make)(const RobotBody& body);
};

/// What people call a phase of the mission of one module type, where the word of all missions says too little.
struct PhaseWords {
  std::string_view module;  // type: "control::Mission"
  msg::MissionPhase phase;
  std::string_view words;  // "searching the pad": what stands behind "the run ended while"
};

/// The parts of a folder of robots/ for programs that run it. `robots/NAME/robot.cpp` defines `RobotKind
/// describe_NAME()`.
struct RobotKind {
  void (*add_modules)(rt::ModuleTypes&) = nullptr;  // its own module types; null: none
  plant::WorldInfo world{};                         // the devices in its world; without a name: no world
  std::span<const PhaseWords> phases{};
  std::span<const BodyModule> body_modules{};
};

/// Of every folder, in the order of their names. The list is made by CMake (robots/CMakeLists.txt).
std::span<const RobotKind> all_robots();

/// The world of this name; null: no robot brings one.
const plant::WorldInfo* find_world(std::string_view name);
/// The names of all worlds.
std::vector<std::string> world_names();

/// Empty: the words of all missions will do.
std::string_view find_phase_words(std::string_view module_type, msg::MissionPhase phase);

/// One world and how it is made. `robots/NAME/world/` defines `plant::WorldType describe_world_of_NAME()`; all of them,
/// for a simulator. Not linked into robots.
std::vector<std::shared_ptr<const plant::WorldType>> all_worlds();

}  // namespace sinew::robots
