#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

/// A robot file with all that it extends.
struct ResolvedRobot {
  std::string text;                     // TOML that stands alone; the file's own text when it extends nothing
  bool extended = false;                // lines of problems are then lines of `text`
  std::vector<rt::Problem> problems{};  // of the files: missing, no TOML, circular
};

/// Merges `text`, of the file `path`, over the file that its key `extends` names (relative to it), which may extend
/// another. A key of the file takes the place of the same key below it; tables are merged key by key, [[thread]],
/// [[chain]], [[failsafe]] and joints by their name; `without = ["module.pad"]` takes tables away.
ResolvedRobot resolve_robot(std::string_view text, const std::string& path);

}  // namespace sinew::app
