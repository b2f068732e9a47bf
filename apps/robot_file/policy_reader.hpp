#pragma once
#include "apps/robot_file/robot_file.hpp"
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

inline constexpr std::string_view kPolicyType = "policy::Policy";

/// Reads what `[module.NAME]` has beside the keys of every module when it is a policy::Policy: its file, observation
/// and commands. The network itself is not read here.
void read_policy(TomlReader& r, RobotFile& robot, rt::ModuleSpec& module);

/// Reads the networks of a robot, each beside the file that names it.
void read_networks(RobotFile& robot);

}  // namespace sinew::app
