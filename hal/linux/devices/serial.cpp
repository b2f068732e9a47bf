#include "hal/linux/devices/serial.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "hal/linux/beyond_posix.hpp"
#include "hal/linux/open_error.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

bool is_gone(int e) { return e == EIO || e == ENODEV || e == ENXIO || e == EPIPE || e == ESHUTDOWN; }

class LinuxSerial final : public Serial {
 public:
  explicit LinuxSerial(int fd, std::string remove = {}) : fd_(fd), remove_(std::move(remove)) {}
  ~LinuxSerial() override {
    ::close(fd_);
    if (!remove_.empty()) ::unlink(remove_.c_str());
  }
  LinuxSerial(const LinuxSerial&) = delete;
  LinuxSerial& operator=(const LinuxSerial&) = delete;

  Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override {
    if (into.empty()) return std::size_t{0};
    for (;;) {
      const ssize_t n = ::read(fd_, into.data(), into.size());
      if (n > 0) return static_cast<std::size_t>(n);
      if (n == 0) return Error{Errc::closed, "serial: the line is gone"};
      if (errno == EINTR) continue;
      if (errno == EAGAIN) return std::size_t{0};
      return failed("serial: read");
    }
  }
  Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    for (;;) {
      const ssize_t n = bytes.empty() ? 0 : ::write(fd_, bytes.data(), bytes.size());
      if (n >= 0) return static_cast<std::size_t>(n);
      if (errno == EINTR) continue;
      if (errno == EAGAIN) return std::size_t{0};
      return failed("serial: write");
    }
  }
  Status set_bit_rate(std::uint32_t bits_per_s) noexcept override {
    if (bits_per_s == 0) return Error{Errc::bad_argument, "serial: bit rate"};
    return beyond_posix::set_bit_rate(fd_, bits_per_s);
  }
  Result<bool> wait_readable(Time deadline) noexcept override {
    pollfd waiting{fd_, POLLIN, 0};
    const std::int64_t left =
        deadline == kNever ? 0 : std::max<std::int64_t>(0, (deadline - system_os().now()).count());
    const timespec limit{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
    const int n = ::ppoll(&waiting, 1, deadline == kNever ? nullptr : &limit, nullptr);
    if (n < 0) return errno == EINTR ? Result<bool>(false) : Result<bool>(failed("serial: poll"));
    if (waiting.revents & POLLIN) return true;
    if (waiting.revents & (POLLHUP | POLLERR | POLLNVAL)) return Error{Errc::closed, "serial: the line is gone"};
    return false;
  }

 private:
  static Error failed(const char* where) { return {is_gone(errno) ? Errc::closed : Errc::io, where, errno}; }
  int fd_;
  std::string remove_;
};

}  // namespace

Result<std::unique_ptr<Serial>> open_serial(const SerialSpec& spec, std::string& why) {
  constexpr OpenHint kHint{"see what is there with: ls -l /dev/serial/by-id /dev/ttyS* /dev/ttyUSB* /dev/ttyACM*"};
  if (spec.bit_rate == 0) {
    why = spec.path + ": bit rate is more than 0";
    return Error{Errc::bad_argument, "serial"};
  }
  if (spec.inverted) {
    why = spec.path +
          ": Linux has no general way to invert a line; put an inverter before RX or switch it on in the UART's "
          "device-tree node, then leave 'inverted' out";
    return Error{Errc::not_supported, "serial: inverted"};
  }
  const int fd = ::open(spec.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return open_error(spec.path, errno, kHint, "serial: open", why);
  auto line = std::make_unique<LinuxSerial>(fd);
  // Two locks: the first keeps other users' processes out, the second our own and root's.
  if (::ioctl(fd, TIOCEXCL) < 0 || ::flock(fd, LOCK_EX | LOCK_NB) < 0) {
    const Error error = open_error(spec.path, errno, kHint, "serial: hold", why);
    if (error.code == Errc::not_supported) why = spec.path + ": is no serial line";
    return error;
  }
  if (auto done = beyond_posix::make_raw(fd, spec); !done) {
    why = spec.path + ": cannot be set up: " + errno_text(static_cast<int>(done.error().detail));
    return done.error();
  }
  if (auto done = line->set_bit_rate(spec.bit_rate); !done) {
    why = spec.path + ": cannot do " + std::to_string(spec.bit_rate) + " bit/s";
    if (done.error().code == Errc::not_supported) why += ", only " + std::to_string(done.error().detail);
    return done.error();
  }
  ::tcflush(fd, TCIFLUSH);  // earlier bytes came at another rate
  if (spec.low_latency) why = beyond_posix::set_latency_timer(fd, spec);
  return std::unique_ptr<Serial>(std::move(line));
}

Result<PseudoSerial> make_pseudo_serial() {
  const int fd = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return Error{Errc::io, "posix_openpt", errno};
  auto end = std::make_unique<LinuxSerial>(fd);
  std::array<char, 128> path{};
  if (::grantpt(fd) != 0 || ::unlockpt(fd) != 0 || ::ptsname_r(fd, path.data(), path.size()) != 0)
    return Error{Errc::io, "ptsname_r", errno};
  if (auto done = beyond_posix::make_raw(fd, {}); !done) return done.error();
  return PseudoSerial{std::move(end), path.data()};
}

Result<std::unique_ptr<Serial>> make_pipe(const std::string& path) {
  std::string why;
  if (::mkfifo(path.c_str(), 0600) != 0) {
    if (errno == EEXIST) return Error{Errc::busy, "mkfifo", errno};
    return open_error(path, errno, {}, "mkfifo", why);
  }
  const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return open_error(path, errno, {}, "open a pipe", why);
  return std::unique_ptr<Serial>(new LinuxSerial(fd, path));
}

}  // namespace sinew::hal
