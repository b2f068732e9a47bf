#include "apps/command/place.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>

#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

Place& known() {
  static Place place;
  return place;
}

fs::path own_folder() { return fs::path(hal::program_path()).parent_path(); }

bool is_file(const fs::path& path) {
  std::error_code ignored;  // a path that cannot be examined counts as missing
  return fs::is_regular_file(path, ignored);
}

}  // namespace

void set_place(const Place& place) { known() = place; }

std::string find_program(const std::string& name) {
  for (const fs::path& folder : {own_folder(), fs::path(known().programs)})
    if (!folder.empty() && is_file(folder / name)) return folder / name;
  return find_in_path(name);
}

std::string find_in_path(const std::string& name) {
  const char* const path = std::getenv("PATH");
  const std::string folders = path ? path : "/usr/local/bin:/usr/bin:/bin";
  for (std::size_t begin = 0; begin < folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    const fs::path file = fs::path(folders.substr(begin, end - begin)) / name;
    if (file.is_absolute() && is_file(file) && ::access(file.c_str(), X_OK) == 0) return file;
    begin = end + 1;
  }
  return {};
}

std::string package_folder() {
  if (!known().package.empty()) return known().package;
  for (const char* from_here : {"..", SINEW_PACKAGE_FROM_PROGRAMS}) {  // a build folder; an installed prefix
    const fs::path folder = (own_folder() / from_here).lexically_normal();
    if (is_file(folder / "SinewConfig.cmake")) return folder;
  }
  return {};
}

}  // namespace sinew::app
