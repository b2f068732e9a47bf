#pragma once
#include "apps/command/command.hpp"

namespace sinew::app {

inline constexpr const char* kGrabAbout =
    "Starts a program so that its pictures (OpenGL, Vulkan) can be a robot's camera (docs/grab.md). Options for sinew "
    "stand before the program: sinew grab [OPTIONS] PROGRAM ARGS...\n"
    "Exit code: the program's; 2: it could not begin.";

/// `sinew grab [options] PROGRAM ARGS...`, `sinew grab --list`, `sinew grab --from NAME --to FILE.png`.
void add_grab_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
