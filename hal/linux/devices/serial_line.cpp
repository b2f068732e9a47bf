// A line's settings by Linux' own calls, which accept any bit rate; their header excludes <termios.h>.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <string>

#include "hal/linux/beyond_posix.hpp"

namespace sinew::hal::beyond_posix {
namespace {

Error serial_error(const char* where) {
  const bool gone = errno == EIO || errno == ENODEV || errno == ENXIO || errno == EPIPE || errno == ESHUTDOWN;
  return {gone ? Errc::closed : Errc::io, where, errno};
}

}  // namespace

Status make_raw(int line, const SerialSpec& spec) noexcept {
  termios2 t{};
  if (::ioctl(line, TCGETS2, &t) < 0) return Error{Errc::io, "serial: TCGETS2", errno};
  t.c_iflag = spec.even_parity ? INPCK : 0;
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag = (t.c_cflag & CBAUD) | CS8 | CREAD | CLOCAL | (spec.even_parity ? PARENB : 0u) |
              (spec.two_stop_bits ? CSTOPB : 0u);
  t.c_cc[VMIN] = 1;  // so that an empty read differs from a lost line
  t.c_cc[VTIME] = 0;
  if (::ioctl(line, TCSETS2, &t) < 0) return Error{Errc::io, "serial: TCSETS2", errno};
  return {};
}

Status set_bit_rate(int line, std::uint32_t bits_per_s) noexcept {
  termios2 t{};
  if (::ioctl(line, TCGETS2, &t) < 0) return serial_error("serial: TCGETS2");
  t.c_cflag = (t.c_cflag & ~static_cast<tcflag_t>(CBAUD)) | BOTHER;
  t.c_ispeed = t.c_ospeed = bits_per_s;
  if (::ioctl(line, TCSETS2, &t) < 0) return serial_error("serial: TCSETS2");
  // A driver that cannot do a rate keeps the old one or picks another one.
  if (::ioctl(line, TCGETS2, &t) < 0) return serial_error("serial: TCGETS2");
  const double off = static_cast<double>(t.c_ospeed) / bits_per_s;
  if (off < 0.97 || off > 1.03)
    return Error{Errc::not_supported, "serial: the driver cannot do this bit rate", t.c_ospeed};
  return {};
}

std::string set_latency_timer(int line, const SerialSpec& spec) {
  std::array<char, PATH_MAX> real{};
  const char* device = ::realpath(spec.path.c_str(), real.data());  // a name of /dev/serial/by-id
  const std::string node = device ? device : spec.path;
  const std::string file = spec.root + (spec.root.ends_with('/') ? "" : "/") + "sys/bus/usb-serial/devices/" +
                           node.substr(node.rfind('/') + 1) + "/latency_timer";
  const auto read_ms = [&file]() -> int {  // -1: there is none
    std::array<char, 16> text{};
    const int in = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (in < 0) return -1;
    const ssize_t n = ::read(in, text.data(), text.size() - 1);
    ::close(in);
    return n > 0 ? ::atoi(text.data()) : 0;
  };
  int ms = read_ms();
  if (ms == -1 || ms == 1) return {};
  // The file is root's. The flag may be set by whoever has the line, and the driver (ftdi_sio) sets the timer by it.
  serial_struct settings{};
  if (::ioctl(line, TIOCGSERIAL, &settings) == 0) {
    settings.flags |= ASYNC_LOW_LATENCY;
    static_cast<void>(::ioctl(line, TIOCSSERIAL, &settings));  // read_ms() shows whether it did
  }
  if (read_ms() == 1) return {};
  const int out = ::open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  const bool set = out >= 0 && ::write(out, "1\n", 2) == 2;
  if (out >= 0) ::close(out);
  if (set) return {};
  ms = read_ms();
  return spec.path + ": its adapter hands bytes over after " + std::to_string(ms) +
         " ms, and may not be set to 1: echo 1 | sudo tee " + file;
}

}  // namespace sinew::hal::beyond_posix
