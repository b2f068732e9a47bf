#pragma once
// Where programs of one user on one machine find each other: a private folder, and lock files that die with their
// process.
#include <memory>
#include <optional>
#include <string>

#include "hal/result.hpp"

namespace sinew::hal {

/// $SINEW_RUN_DIR, else $XDG_RUNTIME_DIR/sinew, else sinew-UID in the temporary folder; made when missing, for its
/// owner only.
/// Errors:  denied when it is a link, no folder, somebody else's, or open to others (a stranger could put a robot of
///          his there); io. `path` is set in any case.
Status run_dir(std::string& path);

/// A file that one living process holds; the kernel lets go when the process ends, however it ends.
/// Thread:  owner.
class FileLock {
 public:
  /// Takes it without waiting and writes our process id into it.
  /// Errors:  busy (detail: process id of the holder, 0 unknown); denied, io.
  static Result<std::unique_ptr<FileLock>> take(const std::string& path);
  /// Process id of who holds it now (0: not known yet); nothing when nobody does. Never disturbs a taker.
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
