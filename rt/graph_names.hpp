#pragma once
// Error texts for a name that a graph does not have.
#include <string>
#include <string_view>

#include "rt/graph.hpp"

namespace sinew::rt {

/// "no module atitude; there are: attitude filter".
std::string no_such_module(const Graph& graph, std::string_view name);

}  // namespace sinew::rt
