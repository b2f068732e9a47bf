#pragma once
#include <string>

#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// The sweep of one run that repeats a run in virtual time: "sinew sweep robots/quad/quad.toml --seeds 7". Empty: a
/// sweep does not run such, or the run was not in virtual time.
std::string sweep_line(const Prepared& prepared, const RunOptions& options);

}  // namespace sinew::app
