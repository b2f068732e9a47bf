#include "apps/parent/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "hal/linux/file.hpp"

namespace sinew::app {

namespace fs = std::filesystem;

namespace {

/// Puts UNDER/latest in the place of the last one in one step, so that nobody ever finds none.
void point_latest(const fs::path& under, const std::string& name) {
  const fs::path latest = under / kLatest, made = under / fmt::format(".{}-{}", kLatest, name);
  std::error_code error;
  const fs::file_status there = fs::symlink_status(latest, error);
  if (fs::exists(there) && !fs::is_symlink(there)) {
    std::fprintf(stderr, "%s: not a link of ours, so it stays as it is: the newest run is in %s\n", latest.c_str(),
                 (under / name).c_str());
    return;
  }
  fs::create_symlink(name, made, error);
  if (!error) fs::rename(made, latest, error);
  if (!error) return;
  std::error_code none;  // what could not be made is not there
  fs::remove(made, none);
  std::fprintf(stderr, "%s: no link to the newest run: %s\n", latest.c_str(), error.message().c_str());
}

}  // namespace

std::string make_run_folder(const std::string& under, std::string_view robot, std::string& why) {
  const std::string name = fmt::format("{}-{:%Y%m%d-%H%M%S}", robot, fmt::gmtime(std::time(nullptr)));
  std::error_code error;
  fs::create_directories(under, error);
  for (int again = 1; !error && again < 1000; ++again) {
    const fs::path path = fs::path(under) / (again == 1 ? name : fmt::format("{}-{}", name, again));
    if (!fs::create_directory(path, error)) continue;
    point_latest(under, path.filename().string());
    return path.string();
  }
  why = under + ": " + (error ? error.message() : "no name is left");
  return {};
}

void remove_run_folder(const std::string& folder) {
  const fs::path path = folder, under = path.parent_path();
  std::error_code error;
  if (!fs::remove(path, error)) return;
  const fs::path latest = under / kLatest;
  if (fs::read_symlink(latest, error) != path.filename() || error) return;
  fs::remove(latest, error);
  fs::path newest;
  fs::file_time_type newest_time = fs::file_time_type::min();
  for (const auto& entry : fs::directory_iterator(under, error)) {
    std::error_code gone;  // by another program: it counts no more
    const auto time = entry.last_write_time(gone);
    if (gone || !entry.is_directory(gone) || time <= newest_time) continue;
    newest = entry.path().filename();
    newest_time = time;
  }
  if (!newest.empty()) point_latest(under, newest.string());
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
