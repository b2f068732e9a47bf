#include "hal/linux/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "hal/linux/beyond_posix.hpp"

namespace sinew::hal {
namespace {

Error file_error(const char* where) {
  switch (errno) {
    case EEXIST:
      return {Errc::busy, where, errno};
    case ENOENT:
    case ENOTDIR:
      return {Errc::not_found, where, errno};
    case EACCES:
    case EPERM:
    case EROFS:
      return {Errc::denied, where, errno};
    default:
      return {Errc::io, where, errno};
  }
}

class LinuxOutputFile final : public OutputFile {
 public:
  LinuxOutputFile(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  ~LinuxOutputFile() override { ::close(fd_); }
  LinuxOutputFile(const LinuxOutputFile&) = delete;
  LinuxOutputFile& operator=(const LinuxOutputFile&) = delete;

  Status append(Parts parts) noexcept override {
    std::array<iovec, 16> list;
    while (!parts.empty()) {
      const std::size_t count = std::min(parts.size(), list.size());
      for (std::size_t i = 0; i < count; ++i)
        list[i] = {const_cast<std::byte*>(parts[i].data()), parts[i].size()};  // writev's type; it only reads
      if (auto done = write_all({list.data(), count}); !done) return done;
      parts = parts.subspan(count);
    }
    return {};
  }
  Status sync() noexcept override {
    while (::fdatasync(fd_) != 0)
      if (errno != EINTR) return Error{Errc::io, "file: fdatasync", errno};
    return {};
  }
  Status cut(std::uint64_t size) noexcept override {
    if (::ftruncate(fd_, static_cast<off_t>(size)) != 0 || ::lseek(fd_, static_cast<off_t>(size), SEEK_SET) < 0)
      return Error{Errc::io, "file: ftruncate", errno};
    return {};
  }
  Result<std::uint64_t> free_bytes() noexcept override {
    struct statvfs disk {};
    if (::fstatvfs(fd_, &disk) != 0) return Error{Errc::io, "file: fstatvfs", errno};
    return std::uint64_t{disk.f_bavail} * disk.f_frsize;
  }
  Status remove() noexcept override {
    if (::unlink(path_.c_str()) != 0) return Error{Errc::io, "file: unlink", errno};
    return {};
  }

 private:
  /// writev() may write less than it was given, most often just before the disk is full.
  Status write_all(std::span<iovec> list) noexcept {
    while (!list.empty()) {
      const ssize_t wrote = ::writev(fd_, list.data(), static_cast<int>(list.size()));
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) return Error{Errc::io, "file: writev", errno};
      auto rest = static_cast<std::size_t>(wrote);
      while (!list.empty() && rest >= list.front().iov_len) {
        rest -= list.front().iov_len;
        list = list.subspan(1);
      }
      if (!list.empty()) {
        if (wrote == 0) return Error{Errc::io, "file: writev", ENOSPC};
        list.front().iov_base = static_cast<char*>(list.front().iov_base) + rest;
        list.front().iov_len -= rest;
      }
    }
    return {};
  }
  int fd_;
  std::string path_;
};

class LinuxInputFile final : public InputFile {
 public:
  LinuxInputFile(int fd, std::uint64_t size) : fd_(fd), size_(size) {}
  ~LinuxInputFile() override { ::close(fd_); }
  LinuxInputFile(const LinuxInputFile&) = delete;
  LinuxInputFile& operator=(const LinuxInputFile&) = delete;

  std::uint64_t size() const noexcept override { return size_; }
  Status read_at(std::uint64_t offset, std::span<std::byte> into) noexcept override {
    while (!into.empty()) {
      const ssize_t got = ::pread(fd_, into.data(), into.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return Error{Errc::io, "file: pread", errno};
      if (got == 0) return Error{Errc::bad_data, "file ends early", static_cast<std::int64_t>(size_)};
      into = into.subspan(static_cast<std::size_t>(got));
      offset += static_cast<std::uint64_t>(got);
    }
    return {};
  }

 private:
  int fd_;
  std::uint64_t size_;
};

/// A new name is on the disk only when its folder is synced.
Status sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, std::max<std::size_t>(slash, 1));
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return file_error("file: open of its folder");
  const bool good = ::fsync(fd) == 0 || errno == EINVAL;  // EINVAL: this file system has no such thing
  const int why = errno;
  ::close(fd);
  if (!good) return Error{Errc::io, "file: fsync of its folder", why};
  return {};
}

}  // namespace

Result<std::unique_ptr<OutputFile>> create_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) return file_error("file: open");
  std::unique_ptr<OutputFile> file = std::make_unique<LinuxOutputFile>(fd, path);
  if (auto done = sync_folder_of(path); !done) {
    static_cast<void>(file->remove());  // so that it can be tried again
    return done.error();
  }
  return file;
}

Result<std::unique_ptr<OutputFile>> open_to_append(const std::string& path) {
  for (;;) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
    if (fd < 0) return file_error("file: open");
    std::unique_ptr<OutputFile> file = std::make_unique<LinuxOutputFile>(fd, path);
    struct stat opened {};
    struct stat named {};
    if (::fstat(fd, &opened) != 0) return file_error("file: stat");
    if (!S_ISREG(opened.st_mode)) return Error{Errc::bad_argument, "file: not an ordinary one"};
    if (!beyond_posix::lock_file(fd)) {
      if (errno == EAGAIN || errno == EACCES) return Error{Errc::busy, "file: open elsewhere", errno};
      return file_error("file: lock");
    }
    // The former owner may have put another file in its place between our open and our lock.
    if (::stat(path.c_str(), &named) != 0 || named.st_ino != opened.st_ino || named.st_dev != opened.st_dev) continue;
    if (auto done = sync_folder_of(path); !done) return done.error();
    return file;
  }
}

Result<std::unique_ptr<InputFile>> open_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a fifo must not block us
  if (fd < 0) return file_error("file: open");
  struct stat about {};
  if (::fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) {
    ::close(fd);
    return Error{Errc::bad_argument, "file: not an ordinary one"};
  }
  std::unique_ptr<InputFile> file = std::make_unique<LinuxInputFile>(fd, static_cast<std::uint64_t>(about.st_size));
  return file;
}

}  // namespace sinew::hal
