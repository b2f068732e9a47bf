#pragma once
#include "apps/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot on the board "none": no devices, no plant. In virtual time for --duration (kBareDuration when
/// nothing is said), in real time until then or until a signal. The exit code of `sinew run`.
int run_without_devices(Prepared& prepared, const RunOptions& options);

inline constexpr rt::Duration kBareDuration = std::chrono::seconds(10);

}  // namespace sinew::app
