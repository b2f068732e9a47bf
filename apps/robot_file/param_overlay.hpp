#pragma once
// Files of parameters: `sinew param save` writes them and `sinew run --params` reads them.
//
//   [mixer]
//   thrust_max_n = 5.5
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

struct OverlayParam {
  std::string module, param;
  rt::ParamValue value;
  int line = 0;
};

struct ParamOverlay {
  std::vector<OverlayParam> params;
  std::vector<rt::Problem> problems;  // of form
};

ParamOverlay parse_overlay(std::string_view text, const std::string& path);
/// A file that cannot be read is one problem.
ParamOverlay load_overlay(const std::string& path);

/// Puts the values in place of those of the robot file. What does not fit (no such module or parameter, a value out of
/// its range) becomes a problem with the line of the overlay. `types` say what modules declare. `line`: the line for
/// problems with these values that are found later (OptionLines).
std::vector<rt::Problem> apply_overlay(const ParamOverlay& overlay, const rt::ModuleTypes& types, rt::GraphSpec& graph,
                                       int line = 0);

/// As TOML has it: 2.0, true, "text".
std::string toml_value(const rt::ParamValue& value);

/// The text of such a file; modules in the order in which they come.
std::string overlay_text(std::string_view robot, const std::vector<OverlayParam>& params);

}  // namespace sinew::app
