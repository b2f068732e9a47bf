#pragma once
#include "apps/robot_file/robot_file.hpp"
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

/// Reads `[net]`.
void read_net(TomlReader& r, RobotFile& robot);

/// After all tables have been read: a radio with the driver "dds" belongs to this robot's program, and needs a `[net]`.
void add_net(RobotFile& robot, Problems& problems);

}  // namespace sinew::app
