#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// The world "mixed" as a robot with these values has it: with wheels and a gripper (kGripperDevices) where its option
/// `wheeled` is 1, else a humanoid (kKidDevices), whose body a file describes.
WorldInfo mixed_world_of(const WorldInfo& world, const WorldValues& robot);

/// For the list of worlds, and for its simulator.
WorldInfo mixed_world();

}  // namespace sinew::plant
