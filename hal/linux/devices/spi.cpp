#include "hal/linux/devices/spi.hpp"

#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "hal/linux/open_error.hpp"

namespace sinew::hal {
namespace {

class LinuxSpi final : public SpiBus {
 public:
  LinuxSpi(int fd, std::uint32_t hz) : fd_(fd), hz_(hz) {}
  ~LinuxSpi() override { ::close(fd_); }
  LinuxSpi(const LinuxSpi&) = delete;
  LinuxSpi& operator=(const LinuxSpi&) = delete;

  Status transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept override {
    if (out.empty() || (!in.empty() && in.size() != out.size()))
      return Error{Errc::bad_argument, "spi: as many bytes come in as go out"};
    spi_ioc_transfer t{};
    t.tx_buf = reinterpret_cast<std::uintptr_t>(out.data());
    t.rx_buf = in.empty() ? 0 : reinterpret_cast<std::uintptr_t>(in.data());
    t.len = static_cast<__u32>(out.size());
    t.speed_hz = hz_;
    t.bits_per_word = 8;
    if (::ioctl(fd_, SPI_IOC_MESSAGE(1), &t) >= 0) return {};
    if (errno == ENODEV || errno == ESHUTDOWN) return Error{Errc::closed, "spi: the controller is gone", errno};
    return Error{Errc::io, "spi", errno};
  }

 private:
  int fd_;
  std::uint32_t hz_;
};

}  // namespace

Result<std::unique_ptr<SpiBus>> open_spi(const SpiSpec& spec, std::string& why) {
  constexpr OpenHint kHint{
      "the chip select needs a 'spidev' node in the device tree (or an overlay); load its module: sudo modprobe "
      "spidev"};
  if (spec.mode > 3 || spec.hz == 0) {
    why = spec.path + ": mode is 0 to 3, hz more than 0";
    return Error{Errc::bad_argument, "spi"};
  }
  const int fd = ::open(spec.path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return open_error(spec.path, errno, kHint, "spi: open", why);
  std::uint8_t mode = spec.mode, bits = 8;
  std::uint32_t hz = spec.hz;
  if (::ioctl(fd, SPI_IOC_WR_MODE, &mode) < 0 || ::ioctl(fd, SPI_IOC_WR_BITS_PER_WORD, &bits) < 0 ||
      ::ioctl(fd, SPI_IOC_WR_MAX_SPEED_HZ, &hz) < 0) {
    const int e = errno;
    ::close(fd);
    const Error error = open_error(spec.path, e, kHint, "spi: set up", why);
    if (error.code == Errc::not_supported) why = spec.path + ": is no SPI device, or cannot do mode and clock";
    return error;
  }
  return std::unique_ptr<SpiBus>(new LinuxSpi(fd, hz));
}

}  // namespace sinew::hal
