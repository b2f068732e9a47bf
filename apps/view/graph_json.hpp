#pragma once
#include <string>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

/// `sinew graph --json`: threads, modules with ports and parameters, topics, chains, actuators.
std::string graph_json(const rt::Graph& graph);

/// A problem and the file that its line is of.
struct PlacedProblem {
  std::string file;
  rt::Problem problem;
};

/// `sinew check --json` of the robot file `path`: the problems, or the slots and bytes of every topic. `graph` is null
/// when there are problems. Those of another file (one it extends, its calibration) have `file`.
std::string check_json(const std::string& path, rt::Graph* graph, const std::vector<PlacedProblem>& problems);

}  // namespace sinew::app
