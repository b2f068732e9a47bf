#include "apps/new_project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

std::string fill(std::string text, const std::string& name, const std::string& package_folder) {
  for (const auto& [mark, value] : {std::pair{std::string("@NAME@"), name}, {std::string("@SINEW@"), package_folder}})
    for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark, at + value.size()))
      text.replace(at, mark.size(), value);
  return text;
}

bool write_file(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  return !out.fail();
}

}  // namespace

std::string refuse_project_name(const std::string& name) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || name[0] < 'a' || name[0] > 'z' || !std::all_of(name.begin(), name.end(), fits))
    return fmt::format("{}: a name of a-z, 0-9 and _ that begins with a letter", name);
  constexpr std::array kTaken{"all",     "clean", "edit_cache",     "help",          "install",
                              "package", "test",  "package_source", "rebuild_cache", "wave_test"};
  if (std::find(kTaken.begin(), kTaken.end(), name) != kTaken.end())
    return fmt::format("{}: CMake or the project itself has a target of this name; take another one", name);
  return {};
}

std::string write_project(const std::string& name, const std::string& folder, const std::string& package_folder) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(folder, error))) return fmt::format("{}: exists; nothing is overwritten", folder);
  fs::create_directories(folder, error);
  if (error) return fmt::format("{}: {}", folder, error.message());
  for (const ProjectFile& t : project_files()) {
    const fs::path path = fs::path(folder) / fill(t.path, name, package_folder);
    if (!write_file(path, fill(t.text, name, package_folder)))
      return fmt::format("{}: cannot be written", path.string());
  }
  return {};
}

}  // namespace sinew::app
