// A line's settings by Linux' own calls, which accept any bit rate; their header excludes <termios.h>.
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <cerrno>

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

}  // namespace sinew::hal::beyond_posix
