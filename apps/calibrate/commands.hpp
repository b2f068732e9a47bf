#pragma once
#include "apps/calibrate/commands.hpp"
#include "apps/command/command.hpp"

namespace sinew::app {

void add_calibrate_command(CLI::App& app,
                           CommandContext& context);  // calibrate imu, joint, mag, camera, legs, camera-offset

}  // namespace sinew::app
