#pragma once
#include <vector>

#include "apps/robot_file/record_options.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// Topics that the robot does not have.
std::vector<rt::Problem> check_recording(const RecordOptions& record, const rt::Graph& graph);

}  // namespace sinew::app
