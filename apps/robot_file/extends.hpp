#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/toml/line_place.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

/// A robot file with all that it extends, with its body, and with what the INI files of its devices say.
struct ResolvedRobot {
  std::string text;                         // TOML that stands alone; the file's own text when it names no other file
  bool extended = false;                    // `text` is not the file's own
  std::vector<rt::Problem> problems{};      // of the files: missing, no TOML, circular: there is no such text
  std::vector<rt::Problem> ini_problems{};  // of INI files; their lines are places behind those of the text
  /// Where line i + 1 of `text` (with problems: of theirs) was written; empty: there, in the file itself.
  std::vector<LinePlace> places{};
};

/// Merges `text`, of the file `path`, over the file that its key `extends` names (relative to it), which may extend
/// another. A key of the file takes the place of the same key below it; tables are merged key by key, [[thread]],
/// [[chain]], [[failsafe]] and joints by their name; `without = ["module.pad"]` takes tables away. What an INI file
/// says (the key `ini` of a device) takes the place of that key. The files that
/// `extends` of [body] and of [motions] name are merged below these tables.
ResolvedRobot resolve_robot(std::string_view text, const std::string& path);

}  // namespace sinew::app
