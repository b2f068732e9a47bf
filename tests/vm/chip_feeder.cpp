// Puts the samples of a simulated world into the registers of a chip: reads the IIO tree that sinew-sim --iio writes,
// and fills the kernel's i2c-stub, from which the kernel's own bmi160 driver reads. So a robot's IMU is the kernel's
// IIO device, from the registers up.
//
//   vm_chip_feeder ROOT ADAPTER CHIP      e.g. vm_chip_feeder /tmp/world 0 0x69; until the world ends
//
// Registers and ranges: Bosch BMI160 datasheet (BST-BMI160-DS000), sections 2.11.5 (DATA) and 1.1: the range must be
// set to 4 g and 2000 deg/s. What is outside of the range is clipped, as in the chip.
#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "hal/linux/devices/iio_device.hpp"

namespace {

constexpr std::uint8_t kGyroX = 0x0c;  // low byte first; y, z, then the accelerometer's three
constexpr double kGyroCounts = 16.4 * 180 / std::numbers::pi, kAccelCounts = 8192 / 9.80665;  // per rad/s, per m/s^2

int fail(const std::string& what) {
  std::fprintf(stderr, "vm_chip_feeder: %s\n", what.c_str());
  return 1;
}

void put(std::uint8_t* at, double counts) {
  const auto n = static_cast<std::int16_t>(std::lround(std::clamp(counts, -32768.0, 32767.0)));
  at[0] = static_cast<std::uint8_t>(n & 0xff), at[1] = static_cast<std::uint8_t>((n >> 8) & 0xff);
}

/// All six numbers in one transfer, so that a reader never finds half of one.
bool write_data(int device, const sinew::msg::Vec3& gyro, const sinew::msg::Vec3& accel) {
  i2c_smbus_data data{};
  data.block[0] = 12;
  put(&data.block[1], gyro.x * kGyroCounts), put(&data.block[3], gyro.y * kGyroCounts);
  put(&data.block[5], gyro.z * kGyroCounts), put(&data.block[7], accel.x * kAccelCounts);
  put(&data.block[9], accel.y * kAccelCounts), put(&data.block[11], accel.z * kAccelCounts);
  i2c_smbus_ioctl_data call{I2C_SMBUS_WRITE, kGyroX, I2C_SMBUS_I2C_BLOCK_DATA, &data};
  return ::ioctl(device, I2C_SMBUS, &call) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sinew;
  if (argc != 4) return fail("ROOT ADAPTER CHIP");
  const std::string path = std::string("/dev/i2c-") + argv[2];
  const int chip = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  // By force: the kernel's driver has the chip.
  if (chip < 0 || ::ioctl(chip, I2C_SLAVE_FORCE, std::strtoul(argv[3], nullptr, 0)) < 0)
    return fail(path + ": " + std::strerror(errno));

  hal::IioSpec spec;
  spec.name = "iio:device0", spec.root = argv[1];
  std::string why;
  const auto tree = hal::IioDevice::find(spec.root, spec.name, why);
  if (!tree) return fail(why);
  hal::IioDevice& world = **tree;
  if (!world.set_up(spec, true, {"anglvel", "accel"}, why) || !world.start_buffer(spec, why)) return fail(why);

  unsigned long samples = 0;
  std::vector<std::uint8_t> scans(world.scan_bytes() * 64);
  for (;;) {
    pollfd wait{world.fd(), POLLIN, 0};
    if (::poll(&wait, 1, -1) < 0) return fail(std::string("poll: ") + std::strerror(errno));
    const auto got = world.read(scans);
    if (!got) break;  // the world has ended
    if (*got == 0 && (wait.revents & POLLHUP) != 0) break;
    for (std::size_t at = 0; at + world.scan_bytes() <= *got; at += world.scan_bytes(), ++samples) {
      const auto scan = std::span(scans).subspan(at, world.scan_bytes());
      if (!write_data(chip, world.axes(0).to_board(world.raw(scan, 0)), world.axes(1).to_board(world.raw(scan, 1))))
        return fail(path + ": " + std::strerror(errno));
    }
  }
  std::printf("%lu samples\n", samples);
  return samples > 0 ? 0 : 1;
}
