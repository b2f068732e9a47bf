#include "hal/linux/run_dir.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "hal/linux/beyond_posix.hpp"

namespace sinew::hal {
namespace {

Error run_dir_error(const char* where) {
  const int why = errno;
  return {why == EACCES || why == EPERM || why == EROFS ? Errc::denied : Errc::io, where, why};
}

std::string path_of_run_dir() {
  const char* own = std::getenv("SINEW_RUN_DIR");
  if (own && *own) return own;
  const char* session = std::getenv("XDG_RUNTIME_DIR");
  if (session && *session) return std::string(session) + "/sinew";
  std::error_code ignored;
  auto folder = std::filesystem::temp_directory_path(ignored);
  if (ignored) folder = P_tmpdir;
  return (folder / ("sinew-" + std::to_string(user_id()))).string();
}

int written_pid(int fd) {
  char text[16] = {};
  const ssize_t n = ::pread(fd, text, sizeof text - 1, 0);
  return n > 0 ? std::atoi(text) : 0;
}

/// False when another process removed or replaced the file while we took it.
bool is_still_at(int fd, const std::string& path) {
  struct stat ours {
  }, there{};
  return ::fstat(fd, &ours) == 0 && ::stat(path.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
         ours.st_dev == there.st_dev;
}

}  // namespace

std::uint32_t user_id() { return ::geteuid(); }
int process_id() { return ::getpid(); }

Status run_dir(std::string& path) {
  path = path_of_run_dir();
  if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST) return run_dir_error("folder of running robots");
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return run_dir_error("folder of running robots");
  if (!S_ISDIR(info.st_mode)) return Error{Errc::denied, "folder of running robots: is no folder"};
  if (info.st_uid != user_id())
    return Error{Errc::denied, "folder of running robots: belongs to another user", info.st_uid};
  if ((info.st_mode & 077) != 0)
    return Error{Errc::denied, "folder of running robots: others may enter it (chmod 700)", info.st_mode & 0777};
  return {};
}

Result<std::unique_ptr<FileLock>> FileLock::take(const std::string& path) {
  for (;;) {
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0) return run_dir_error("lock file");
    if (!beyond_posix::lock_file(fd)) {
      const Error e = errno == EAGAIN || errno == EACCES ? Error{Errc::busy, "lock file", written_pid(fd)}
                                                         : run_dir_error("lock file");
      ::close(fd);
      return e;
    }
    if (!is_still_at(fd, path)) {
      ::close(fd);
      continue;
    }
    const std::string text = std::to_string(process_id()) + "\n";
    if (::ftruncate(fd, 0) != 0 || ::pwrite(fd, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
      const Error e = run_dir_error("lock file");
      ::close(fd);
      return e;
    }
    return std::unique_ptr<FileLock>(new FileLock(fd, path));
  }
}

std::optional<int> FileLock::holder(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return std::nullopt;
  const bool held = beyond_posix::is_locked_by_another(fd);
  const int pid = written_pid(fd);
  ::close(fd);
  return held ? std::optional<int>(pid) : std::nullopt;
}

FileLock::~FileLock() {
  ::unlink(path_.c_str());  // first: a process that opens it from now on finds another file
  ::close(fd_);
}

}  // namespace sinew::hal
