#pragma once
#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot without a plant and without a record: on the board "linux" with its real devices, in real time
/// only; on the board "none" without any. Ends after --duration (in virtual time kBareDuration when nothing is said),
/// when the mission ends, or by a signal. With actuators, in a process of its own beside a parent, unless the options
/// say otherwise. The exit code of `sinew run`.
int run_on_devices(Prepared& prepared, const RunOptions& options);

inline constexpr rt::Duration kBareDuration = std::chrono::seconds(10);

}  // namespace sinew::app
