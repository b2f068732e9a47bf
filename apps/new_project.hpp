#pragma once
#include <span>
#include <string>

namespace sinew::app {

/// A file of the project, with @NAME@ and @SINEW@ (the package folder) left open. From apps/new_project/.
struct ProjectFile {
  const char *path, *text;
};
std::span<const ProjectFile> project_files();

/// Why a project may not be called so; empty: it may. Names are [a-z][a-z0-9_]*, and no target that CMake keeps for
/// itself.
std::string refuse_project_name(const std::string& name);

/// Writes a project that builds and runs: one module, its test, a robot file, main(), CMakeLists.txt, README.md. The
/// answer says what went wrong; empty: nothing did.
/// Errors:  the folder exists (nothing is touched then), or cannot be written.
std::string write_project(const std::string& name, const std::string& folder, const std::string& package_folder);

}  // namespace sinew::app
