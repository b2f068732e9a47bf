#pragma once
#include <optional>
#include <string>
#include <vector>

#include "kinematics/body.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

class TomlReader;

struct LoadedBody {
  kinematics::Body body;
  std::vector<rt::Problem> problems{};  // of the file: missing, no TOML, keys, values, links that hang on nothing
};

/// Reads a body from TOML: docs/bodies.md. Links with `mirror = true`, whose names begin with "l_", are there a second
/// time with "r_" at y mirrored; a mirrored joint with the same angle moves as the mirror image.
LoadedBody parse_body(std::string_view text, const std::string& path);
/// The same tables of a robot file: [body], [[body.link]].
void read_body(TomlReader& r, kinematics::Body& body);
/// From a file of a body, or from the [body] of a robot file; with what these extend. Errors: problems; lines are those
/// of the file, or of one that it extends.
LoadedBody load_body(const std::string& path);
/// The text of such a file with all that it extends, for parse_body(). Nothing: it cannot be read.
std::optional<std::string> body_text(const std::string& path);

}  // namespace sinew::app
