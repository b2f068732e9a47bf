#pragma once
// Error texts for a name that a graph does not have.
#include <string>
#include <string_view>

#include "rt/graph.hpp"

namespace sinew::rt {

/// "no module atitude; there are: attitude filter; did you mean attitude?".
std::string no_such_module(const Graph& graph, std::string_view name);
/// "no topic imu.rw; did you mean imu.raw?".
std::string no_such_topic(const Graph& graph, std::string_view name);
/// "no thread contrl; there are: guardian control; did you mean control?".
std::string no_such_thread(const Graph& graph, std::string_view name);

}  // namespace sinew::rt
