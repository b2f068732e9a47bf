#pragma once
#include <memory>

#include "apps/run/run_setup.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {

/// Starts the program with DDS of a robot that has a `[net]`, in real time; says that it did, or why not: the robot
/// runs without it. Null: none was started. It ends with the object; it starts itself anew when it fails.
std::unique_ptr<hal::ChildProcess> start_net(const Prepared& prepared, const RunOptions& options);

}  // namespace sinew::app
