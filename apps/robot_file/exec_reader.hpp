#pragma once
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

/// The execution-time keys of a module or of the guardian: at most one of them. docs/robot-file.md.
void read_exec(TomlReader& r, rt::ExecModel& exec);

}  // namespace sinew::app
