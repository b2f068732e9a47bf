#include "apps/parent/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstring>
#include <ctime>
#include <filesystem>

#include "hal/linux/file.hpp"

namespace sinew::app {

namespace fs = std::filesystem;

std::string make_run_folder(const std::string& under, std::string_view robot, std::string& why) {
  const std::string name = fmt::format("{}-{:%Y%m%d-%H%M%S}", robot, fmt::gmtime(std::time(nullptr)));
  std::error_code error;
  fs::create_directories(under, error);
  for (int again = 1; !error && again < 1000; ++again) {
    const fs::path path = fs::path(under) / (again == 1 ? name : fmt::format("{}-{}", name, again));
    if (fs::create_directory(path, error)) return path.string();
  }
  why = under + ": " + (error ? error.message() : "no name is left");
  return {};
}

record::DumpFile next_ring_file(const std::string& folder) {
  std::string path;
  std::error_code error;
  for (unsigned n = 1; path.empty() || (fs::exists(path, error) && !error); ++n)
    path = fmt::format("{}/ring-{}.mcap", folder, n);
  return {path, [path] { return hal::create_file(path); }, [path] { return hal::open_file(path); }};
}

std::string error_text(const hal::Error& error) {
  if (error.code == hal::Errc::io && error.detail > 0)
    return fmt::format("{}: {}", error.where, std::strerror(static_cast<int>(error.detail)));
  return fmt::format("{}: {}", error.where, hal::to_string(error.code));
}

}  // namespace sinew::app
