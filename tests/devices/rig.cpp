#include "rig.hpp"

#include "hal/linux/devices/gpio.hpp"
#include "hal/linux/devices/i2c.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/linux/devices/spi.hpp"

namespace sinew::test {

hal::Result<std::unique_ptr<hal::I2cBus>> BenchConnectors::i2c(const std::string& path, std::string& why) {
  return hal::open_i2c(path, why);
}
hal::Result<std::unique_ptr<hal::SpiBus>> BenchConnectors::spi(const hal::SpiSpec& spec, std::string& why) {
  return hal::open_spi(spec, why);
}
hal::Result<std::unique_ptr<hal::Serial>> BenchConnectors::serial(const hal::SerialSpec& spec, std::string& why) {
  return hal::open_serial(spec, why);
}
hal::Result<std::unique_ptr<hal::Gpio>> BenchConnectors::gpio(const hal::GpioSpec& spec, std::string& why) {
  return hal::open_gpio(spec, why);
}

}  // namespace sinew::test
