#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

/// Where somebody wrote a line.
struct LinePlace {
  std::string file;
  int line = 0;  // 0: of the file as a whole
};

/// A robot file with all that it extends.
struct ResolvedRobot {
  std::string text;                     // TOML that stands alone; the file's own text when it extends nothing
  bool extended = false;                // `text` is not the file's own
  std::vector<rt::Problem> problems{};  // of the files: missing, no TOML, circular
  /// Where line i + 1 of `text` (with problems: of theirs) was written; empty: there, in the file itself.
  std::vector<LinePlace> places{};
};

/// Merges `text`, of the file `path`, over the file that its key `extends` names (relative to it), which may extend
/// another. A key of the file takes the place of the same key below it; tables are merged key by key, [[thread]],
/// [[chain]], [[failsafe]] and joints by their name; `without = ["module.pad"]` takes tables away.
ResolvedRobot resolve_robot(std::string_view text, const std::string& path);

}  // namespace sinew::app
