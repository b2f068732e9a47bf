// Writes registers of a chip, one byte each, as SMBus does: fills the kernel's i2c-stub before a driver looks at it.
//
//   vm_i2c_registers ADAPTER CHIP REGISTER=VALUE...     e.g. vm_i2c_registers 0 0x69 0x00=0xd1 0x12=0x34
#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace {

/// 0x.. or decimal, at most `limit`.
std::optional<unsigned> number(std::string_view text, unsigned limit) {
  const bool hex = text.starts_with("0x");
  if (hex) text.remove_prefix(2);
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
  if (error != std::errc() || end != text.data() + text.size() || value > limit) return std::nullopt;
  return value;
}

bool write_byte(int device, std::uint8_t reg, std::uint8_t value) {
  i2c_smbus_data data{};
  data.byte = value;
  i2c_smbus_ioctl_data call{I2C_SMBUS_WRITE, reg, I2C_SMBUS_BYTE_DATA, &data};
  return ::ioctl(device, I2C_SMBUS, &call) == 0;
}

int fail(const std::string& what) {
  std::fprintf(stderr, "vm_i2c_registers: %s\n", what.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return fail("ADAPTER CHIP REGISTER=VALUE...");
  const auto chip = number(argv[2], 0x7f);
  if (!chip) return fail(std::string(argv[2]) + ": an address up to 0x7f");
  const std::string path = std::string("/dev/i2c-") + argv[1];
  const int device = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (device < 0 || ::ioctl(device, I2C_SLAVE, static_cast<unsigned long>(*chip)) < 0)
    return fail(path + ": " + std::strerror(errno));
  for (int i = 3; i < argc; ++i) {
    const std::string_view pair = argv[i];
    const auto equals = pair.find('=');
    const auto reg = number(pair.substr(0, equals), 0xff);
    const auto value = equals == pair.npos ? std::nullopt : number(pair.substr(equals + 1), 0xff);
    if (!reg || !value) return fail(std::string(pair) + ": REGISTER=VALUE, each up to 0xff");
    if (!write_byte(device, static_cast<std::uint8_t>(*reg), static_cast<std::uint8_t>(*value)))
      return fail(std::string(pair) + ": " + std::strerror(errno));
  }
  ::close(device);
  return 0;
}
