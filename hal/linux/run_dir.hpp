#pragma once
// A meeting place for programs of one user on one machine: a private folder, and lock files that end with their
// process.
#include <memory>
#include <optional>
#include <string>

#include "hal/result.hpp"

namespace sinew::hal {

/// $SINEW_RUN_DIR, else $XDG_RUNTIME_DIR/sinew, else sinew-UID in the temporary folder; made when missing, for its
/// owner only.
/// Errors:  denied when it is a link, no folder, another user's, or open to others (a stranger could put a robot
///          there); io. `path` is set in any case.
Status run_dir(std::string& path);

/// A file that one living process holds; the kernel releases it when the process ends, however it ends.
/// Thread:  owner.
class FileLock {
 public:
  /// Takes it without waiting and writes our process id into it.
  /// Errors:  busy (detail: process id of the holder, 0 unknown); denied, io.
  static Result<std::unique_ptr<FileLock>> take(const std::string& path);
  /// Process id of the present holder (0: not known yet); nothing when there is none. Never disturbs a taker.
  static std::optional<int> holder(const std::string& path);
  ~FileLock();  // removes the file
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  FileLock(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  int fd_;
  std::string path_;
};

/// The user that this process acts for.
std::uint32_t user_id();
int process_id();

}  // namespace sinew::hal
