#include "tap/names.hpp"

#include <algorithm>
#include <filesystem>

#include "hal/did_you_mean.hpp"

namespace sinew::tap {
namespace {

constexpr std::string_view kLockSuffix = ".lock", kSocketSuffix = ".sock";
constexpr std::size_t kMaxName = 40;  // a socket's path has 107 bytes in all

bool good_name(std::string_view name) {
  const auto good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kMaxName && std::all_of(name.begin(), name.end(), good);
}

std::string words_of(const hal::Error& e, const std::string& path) {
  return path + ": " + e.where + ": " + hal::to_string(e.code) + " (" + std::to_string(e.detail) + ")";
}

std::string path_of(const std::string& folder, std::string_view robot, std::string_view suffix) {
  return folder + "/" + std::string(robot) + std::string(suffix);
}

}  // namespace

hal::Result<std::unique_ptr<Name>> Name::take(std::string_view robot, std::string& why) {
  if (!good_name(robot)) {
    why = "robot name \"" + std::string(robot) + "\": letters, digits, _ and -, at most " + std::to_string(kMaxName);
    return hal::Error{hal::Errc::bad_argument, "robot name"};
  }
  std::string folder;
  if (const auto made = hal::run_dir(folder); !made) {
    why = words_of(made.error(), folder);
    return made.error();
  }
  const std::string lock_path = path_of(folder, robot, kLockSuffix);
  auto lock = hal::FileLock::take(lock_path);
  if (!lock) {
    why = lock.error().code == hal::Errc::busy
              ? "robot \"" + std::string(robot) + "\" runs already, as process " + std::to_string(lock.error().detail)
              : words_of(lock.error(), lock_path);
    return lock.error();
  }
  return std::unique_ptr<Name>(new Name(std::string(robot), path_of(folder, robot, kSocketSuffix), std::move(*lock)));
}

hal::Result<std::vector<Running>> running(std::string& why) {
  std::string folder;
  if (const auto there = hal::run_dir(folder); !there) {
    why = words_of(there.error(), folder);
    return there.error();
  }
  std::vector<Running> all;
  std::error_code failed;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string file = at->path().filename().string();
    if (!file.ends_with(kLockSuffix)) continue;
    const auto pid = hal::FileLock::holder(at->path().string());
    if (!pid) continue;
    const std::string robot = file.substr(0, file.size() - kLockSuffix.size());
    all.push_back({robot, *pid, path_of(folder, robot, kSocketSuffix)});
  }
  std::sort(all.begin(), all.end(), [](const Running& a, const Running& b) { return a.robot < b.robot; });
  return all;
}

hal::Result<Running> find_running(std::string_view robot, std::string& why) {
  auto all = running(why);
  if (!all) return all.error();
  std::string names;
  std::vector<std::string> known;
  for (const Running& r : *all) {
    known.push_back(r.robot);
    if (r.robot == robot || (robot.empty() && all->size() == 1)) return r;
    names += (names.empty() ? "" : ", ") + r.robot;
  }
  if (robot.empty() && !all->empty()) {
    why = "several robots run; name one of " + names;
    return hal::Error{hal::Errc::bad_argument, "robot name"};
  }
  why = (robot.empty() ? "no robot runs" : "no robot \"" + std::string(robot) + "\" runs") +
        (names.empty() ? "" : "; there is " + names) + hal::did_you_mean(robot, known);
  return hal::Error{hal::Errc::not_found, "robot name"};
}

}  // namespace sinew::tap
