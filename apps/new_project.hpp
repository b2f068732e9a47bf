#pragma once
#include <span>
#include <string>

namespace sinew::app {

/// A template of one project file, from apps/new_project/; @NAME@ and @SINEW@ (the package folder) are not filled in.
struct ProjectFile {
  const char *path, *text;
};
std::span<const ProjectFile> project_files();

/// Why a project may not have this name; empty: it may. A name is [a-z][a-z0-9_]*, and no target that CMake reserves.
std::string refuse_project_name(const std::string& name);

/// Writes a project that builds and runs: one module, its test, a robot file, main(), CMakeLists.txt, README.md.
/// Returns what went wrong; empty: nothing.
/// Errors:  the folder exists (nothing is touched then), or cannot be written.
std::string write_project(const std::string& name, const std::string& folder, const std::string& package_folder);

}  // namespace sinew::app
