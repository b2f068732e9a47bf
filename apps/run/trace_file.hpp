#pragma once
#include <string>

#include "rt/exec/runner.hpp"

namespace sinew::app {

/// Writes the time line of the last second as Chrome trace JSON. False: it could not be written; the reason is printed.
bool write_trace(const std::string& path, const rt::Runner& runner);

}  // namespace sinew::app
