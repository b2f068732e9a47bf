#pragma once
// Values of parameters that are tried out: MODULE.PARAM=FROM:TO:COUNT, the same with :log, or MODULE.PARAM=A,B,C.
#include <optional>
#include <string>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

struct SweptParam {
  std::string module, param;
  std::vector<rt::ParamValue> values;  // the parameter accepts all; no value is there twice
  std::string name() const { return module + "." + param; }
};

/// Errors:  nothing, with `why`: form, a module or parameter that is not in the graph, a value that it does not accept.
std::optional<SweptParam> parse_sweep(const std::string& text, const rt::Graph& graph, std::string& why);

/// One value of each parameter.
using SweepPoint = std::vector<rt::ParamValue>;
/// All combinations, the last parameter fastest.
std::vector<SweepPoint> grid(const std::vector<SweptParam>& params);

/// Replaces the graph's values by those of a point.
void apply(const std::vector<SweptParam>& params, const SweepPoint& point, rt::GraphSpec& spec);

}  // namespace sinew::app
