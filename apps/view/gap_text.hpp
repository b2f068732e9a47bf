#pragma once
#include <string>

#include "rt/exec/runner.hpp"

namespace sinew::app {

/// One line for each thread that was without the processor though ready, for 40 ms or more: how often, how long, and
/// what that looks like. Empty when there was none.
std::string gap_lines(const rt::Graph& graph, rt::Runner& runner);

}  // namespace sinew::app
