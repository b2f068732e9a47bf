#include "hal/linux/devices/i2c.hpp"

#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>

#include "hal/linux/open_error.hpp"

namespace sinew::hal {
namespace {

using I2cBytes = std::span<const std::uint8_t>;
constexpr std::size_t kMost = 4096;  // of one message; the kernel refuses 8192 and more

Error transfer_error(int why) {
  switch (why) {
    case ENXIO:
    case EREMOTEIO:
      return {Errc::not_found, "i2c: nothing answers at this address", why};
    case ENODEV:
    case ESHUTDOWN:
      return {Errc::closed, "i2c: the adapter is gone", why};
    case ETIMEDOUT:
      return {Errc::timeout, "i2c: the bus is held", why};
    case EBUSY:
      return {Errc::busy, "i2c: a kernel driver holds this address", why};
    default:
      return {Errc::io, "i2c", why};
  }
}

class LinuxI2c final : public I2cBus {
 public:
  LinuxI2c(int fd, unsigned long functions) : fd_(fd), functions_(functions) {}
  ~LinuxI2c() override { ::close(fd_); }
  LinuxI2c(const LinuxI2c&) = delete;
  LinuxI2c& operator=(const LinuxI2c&) = delete;

  Status transfer(std::uint8_t address, I2cBytes write, std::span<std::uint8_t> read) noexcept override {
    if (address > 0x7F || write.size() > kMost || read.size() > kMost || (write.empty() && read.empty()))
      return Error{Errc::bad_argument, "i2c: no such transfer", address};
    return functions_ & I2C_FUNC_I2C ? combined(address, write, read) : smbus(address, write, read);
  }

 private:
  Status combined(std::uint8_t address, I2cBytes write, std::span<std::uint8_t> read) noexcept {
    std::array<i2c_msg, 2> messages{};
    unsigned count = 0;
    if (auto free = claim(address); !free) return free;
    if (!write.empty())  // the kernel's structure is not const; it only reads these bytes
      messages[count++] = {address, 0, static_cast<__u16>(write.size()), const_cast<__u8*>(write.data())};
    if (!read.empty()) messages[count++] = {address, I2C_M_RD, static_cast<__u16>(read.size()), read.data()};
    i2c_rdwr_ioctl_data data{messages.data(), count};
    if (::ioctl(fd_, I2C_RDWR, &data) < 0) return transfer_error(errno);
    return {};
  }

  /// I2C_RDWR ignores a kernel driver that holds the chip, and two users would confuse the chip; I2C_SLAVE does not.
  /// Source:  Linux drivers/i2c/i2c-dev.c, i2cdev_check_addr(): EBUSY for an address with a driver.
  Status claim(std::uint8_t address) noexcept {
    if (claimed_[address].load(std::memory_order_relaxed)) return {};
    const std::lock_guard lock(mutex_);
    if (::ioctl(fd_, I2C_SLAVE, static_cast<unsigned long>(address)) < 0) return transfer_error(errno);
    claimed_[address].store(true, std::memory_order_relaxed);  // relaxed: a second claim does no harm
    return {};
  }

  Status smbus(std::uint8_t address, I2cBytes write, std::span<std::uint8_t> read) noexcept {
    const std::lock_guard lock(mutex_);  // the address belongs to the open file, not to the call
    if (::ioctl(fd_, I2C_SLAVE, static_cast<unsigned long>(address)) < 0) return transfer_error(errno);
    if (read.empty()) return write_registers(write);
    if (write.size() != 1) return Error{Errc::not_supported, "i2c: this adapter reads registers only (SMBus)"};
    return read_registers(write[0], read);
  }

  Status call(std::uint8_t direction, std::uint8_t command, std::uint32_t size, i2c_smbus_data* data) noexcept {
    i2c_smbus_ioctl_data arguments{direction, command, size, data};
    if (::ioctl(fd_, I2C_SMBUS, &arguments) < 0) return transfer_error(errno);
    return {};
  }

  Status write_registers(I2cBytes write) noexcept {
    if (write.size() == 1) return call(I2C_SMBUS_WRITE, write[0], I2C_SMBUS_BYTE, nullptr);
    i2c_smbus_data data{};
    for (std::size_t at = 1; at < write.size();) {
      const auto command = static_cast<std::uint8_t>(write[0] + at - 1);
      const std::size_t left = write.size() - at;
      Status done;
      if (left > 1 && functions_ & I2C_FUNC_SMBUS_WRITE_I2C_BLOCK) {
        const std::size_t n = std::min<std::size_t>(left, I2C_SMBUS_BLOCK_MAX);
        data.block[0] = static_cast<__u8>(n);
        std::copy_n(write.begin() + static_cast<std::ptrdiff_t>(at), n, data.block + 1);
        done = call(I2C_SMBUS_WRITE, command, I2C_SMBUS_I2C_BLOCK_DATA, &data);
        at += n;
      } else {
        data.byte = write[at++];
        done = call(I2C_SMBUS_WRITE, command, I2C_SMBUS_BYTE_DATA, &data);
      }
      if (!done) return done;
    }
    return {};
  }

  Status read_registers(std::uint8_t first, std::span<std::uint8_t> read) noexcept {
    i2c_smbus_data data{};
    for (std::size_t at = 0; at < read.size();) {
      const auto command = static_cast<std::uint8_t>(first + at);
      if (functions_ & I2C_FUNC_SMBUS_READ_I2C_BLOCK) {
        const std::size_t n = std::min<std::size_t>(read.size() - at, I2C_SMBUS_BLOCK_MAX);
        data.block[0] = static_cast<__u8>(n);
        if (auto done = call(I2C_SMBUS_READ, command, I2C_SMBUS_I2C_BLOCK_DATA, &data); !done) return done;
        if (data.block[0] != n) return Error{Errc::io, "i2c: fewer bytes than asked for", data.block[0]};
        std::copy_n(data.block + 1, n, read.begin() + static_cast<std::ptrdiff_t>(at));
        at += n;
      } else {
        if (auto done = call(I2C_SMBUS_READ, command, I2C_SMBUS_BYTE_DATA, &data); !done) return done;
        read[at++] = data.byte;
      }
    }
    return {};
  }

  int fd_;
  unsigned long functions_;
  std::mutex mutex_;
  std::array<std::atomic<bool>, 128> claimed_{};  // no driver had the address at its first use
};

}  // namespace

Result<std::unique_ptr<I2cBus>> open_i2c(const std::string& path, std::string& why) {
  constexpr OpenHint kHint{"load the module (sudo modprobe i2c-dev) and switch the bus on in the device tree"};
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return open_error(path, errno, kHint, "i2c: open", why);
  unsigned long functions = 0;
  if (::ioctl(fd, I2C_FUNCS, &functions) < 0) {
    const int e = errno;
    ::close(fd);
    const Error error = open_error(path, e, kHint, "i2c: I2C_FUNCS", why);
    if (error.code == Errc::not_supported) why = path + ": is no I2C bus; one is called /dev/i2c-N";
    return error;
  }
  return std::unique_ptr<I2cBus>(new LinuxI2c(fd, functions));
}

}  // namespace sinew::hal
