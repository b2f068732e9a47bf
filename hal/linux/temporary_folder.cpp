#include "hal/linux/temporary_folder.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <filesystem>
#include <random>
#include <set>
#include <string_view>

namespace sinew::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLockEnd = ".lock";
constexpr int kMostTries = 100;
constexpr std::size_t kLetters = 6;  // few: the path of a socket has 107 characters at most

std::string random_letters() {
  constexpr std::string_view kAll = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::random_device random;
  std::string letters;
  while (letters.size() < kLetters) letters += kAll[random() % kAll.size()];
  return letters;
}

bool is_ours(const std::string& path, mode_t type) {
  struct stat info {};
  return ::lstat(path.c_str(), &info) == 0 && (info.st_mode & S_IFMT) == type && info.st_uid == user_id();
}

/// Removes the folders and locks with this beginning that no living process holds.
void remove_left_behind(const fs::path& parent, const std::string& begin) {
  std::error_code ignored;  // what cannot be removed stays, and disturbs nobody
  std::set<std::string> found;
  for (fs::directory_iterator file(parent, ignored), end; !ignored && file != end; file.increment(ignored)) {
    std::string name = file->path().filename().string();
    if (name.ends_with(kLockEnd)) name.resize(name.size() - kLockEnd.size());
    if (name.size() == begin.size() + kLetters && name.starts_with(begin)) found.insert((parent / name).string());
  }
  for (const std::string& folder : found) {
    const std::string lock = folder + std::string(kLockEnd);
    if (!is_ours(folder, S_IFDIR) && !is_ours(lock, S_IFREG)) continue;
    if (const auto taken = FileLock::take(lock); taken && is_ours(folder, S_IFDIR)) fs::remove_all(folder, ignored);
  }
}

}  // namespace

Result<std::unique_ptr<TemporaryFolder>> TemporaryFolder::make(const std::string& begin) {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  if (error) return Error{Errc::io, "temporary folder", error.value()};
  remove_left_behind(parent, begin);
  for (int i = 0; i < kMostTries; ++i) {
    const std::string path = (parent / (begin + random_letters())).string();
    auto lock = FileLock::take(path + std::string(kLockEnd));
    if (!lock && lock.error().code == Errc::busy) continue;
    if (!lock) return lock.error();
    if (::mkdir(path.c_str(), 0700) == 0)
      return std::unique_ptr<TemporaryFolder>(new TemporaryFolder(path, std::move(*lock)));
    if (errno != EEXIST) return Error{errno == EACCES ? Errc::denied : Errc::io, "temporary folder", errno};
  }
  return Error{Errc::busy, "temporary folder"};
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // the next make() tries again
  fs::remove_all(path_, ignored);
}

}  // namespace sinew::hal
