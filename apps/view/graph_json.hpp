#pragma once
#include <string>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

/// `sinew graph --json`: threads, modules with ports and parameters, topics, chains, actuators.
std::string graph_json(const rt::Graph& graph);

/// `sinew check --json`: the problems, or the slots and bytes of every topic. `graph` is null when there are problems.
/// Those of its calibration file come after the others, with `file`.
std::string check_json(const std::string& path, rt::Graph* graph, const std::vector<rt::Problem>& problems,
                       const std::string& calibration, const std::vector<rt::Problem>& calibrated);

}  // namespace sinew::app
