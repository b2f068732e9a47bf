#pragma once
#include "apps/robot_file/robot_file.hpp"
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

/// Reads `[team]`.
void read_team(TomlReader& r, RobotFile& robot);

/// After all modules have been read: finds the remote topics ("robot2/ball.model") that their inputs name, and makes
/// the module `mates` of a robot with a `[team]`. A thread of the robot file has to name it in its order.
void add_team(RobotFile& robot, Problems& problems);

}  // namespace sinew::app
