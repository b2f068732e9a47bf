#pragma once
#include <string>
#include <vector>

#include "motion/motion_book.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

class TomlReader;

struct LoadedMotions {
  motion::MotionBook book;
  std::vector<rt::Problem> problems{};  // of the file: missing, no TOML, keys, values, joints that the body has not
};

/// Reads the motions of a body from TOML: docs/walking.md. A joint without "l_" or "r_" before it names both sides.
LoadedMotions parse_motions(std::string_view text, const std::string& path, const kinematics::Body& body);
/// The same tables of a robot file: [motions.walk].
void read_motions(TomlReader& r, const kinematics::Body& body, motion::MotionBook& book);
/// From a file, which may extend another one: `extends = "op3_motion.toml"`. Errors: problems; lines are those of the
/// file, or of the one that it extends.
LoadedMotions load_motions(const std::string& path, const kinematics::Body& body);

/// The file's text again: each number of the tables that differs from its default, and all poses.
std::string motions_text(const motion::MotionBook& book, const kinematics::Body& body, const std::string& about);

}  // namespace sinew::app
