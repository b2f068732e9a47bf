#include "hal/linux/watchdog.hpp"

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

class KernelWatchdog final : public Watchdog {
 public:
  KernelWatchdog(int fd, Duration timeout) : fd_(fd), timeout_(timeout) {}
  ~KernelWatchdog() override { ::close(fd_); }
  KernelWatchdog(const KernelWatchdog&) = delete;
  KernelWatchdog& operator=(const KernelWatchdog&) = delete;

  Status feed() noexcept override { return say('\0'); }
  Duration timeout() const noexcept override { return timeout_; }
  Status release() noexcept override { return say('V'); }

 private:
  Status say(char c) noexcept {
    ssize_t n = 0;
    do n = ::write(fd_, &c, 1);
    while (n < 0 && errno == EINTR);
    if (n == 1) return {};
    return Error{Errc::io, "watchdog: write", errno};
  }

  int fd_;
  Duration timeout_;
};

Errc code_of(int why) {
  switch (why) {
    case ENOENT:
    case ENXIO:
      return Errc::not_found;
    case EACCES:
    case EPERM:
      return Errc::denied;
    case EBUSY:
      return Errc::busy;
    default:
      return Errc::io;
  }
}

}  // namespace

Result<std::unique_ptr<Watchdog>> open_watchdog(const std::string& path, Duration timeout) {
  if (timeout < 1s) return Error{Errc::bad_argument, "watchdog: the timeout is at least 1 s", timeout.count()};
  // Not blocking: a pipe without a reader, or a full one, is an error and never a wait.
  const int fd = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const int why = errno;
    return Error{code_of(why), "watchdog: open", why};
  }
  struct stat info {};
  if (::fstat(fd, &info) == 0 && S_ISCHR(info.st_mode)) {
    int seconds = static_cast<int>((timeout + 1s - Duration{1}) / 1s);
    // A device with one fixed timeout refuses the first and answers the second.
    if (::ioctl(fd, WDIOC_SETTIMEOUT, &seconds) == 0 || ::ioctl(fd, WDIOC_GETTIMEOUT, &seconds) == 0)
      timeout = std::chrono::seconds(seconds);
  }
  return std::unique_ptr<Watchdog>(new KernelWatchdog(fd, timeout));
}

}  // namespace sinew::hal
