#pragma once
#include <string>

#include "rt/exec/runner.hpp"

namespace sinew::app {

/// One line for each thread that was ready, but without the processor for 40 ms or more: how often, how long, and the
/// probable cause. Empty: there is none.
std::string gap_lines(const rt::Graph& graph, rt::Runner& runner);

}  // namespace sinew::app
