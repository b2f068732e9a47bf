#pragma once
#include "apps/robot_file/robot_file.hpp"
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

/// Reads `[ros2]`.
void read_ros2(TomlReader& r, RobotFile& robot);

}  // namespace sinew::app
