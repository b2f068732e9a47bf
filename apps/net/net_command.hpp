#pragma once
#include "apps/command/command.hpp"

namespace sinew::app {

inline constexpr const char* kNetAbout =
    "DDS and ROS 2 for a robot, in a program of its own (docs/net.md): the robot's [net] says which network; its radio "
    "with the driver \"dds\" is heard and said there, and its topics are in a ROS 2 graph by [ros2] (docs/ros2.md).\n"
    "Ends with Ctrl-C. Exit code 0: it was ended, 2: it could not begin.";

/// `sinew net FILE.toml` becomes the program sinew-net; `sinew net status` asks it.
void add_net_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
