#include "hal/linux/connectors.hpp"

namespace sinew::hal {

Result<std::unique_ptr<Connectors>> LinuxConnectors::open(Os& os, std::string& why) {
  // Its thread is an interrupt thread: above every module that waits for a device.
  auto watch = FdWatch::start(os, {"devices", 95, {}, std::size_t{64} * 1024});
  if (!watch) {
    why = "the thread that watches the devices does not start";
    return watch.error();
  }
  return std::unique_ptr<Connectors>(new LinuxConnectors(os, std::move(*watch)));
}

namespace {
Error none(std::string& why) { return why = "not in this build", Error{Errc::not_supported, "LinuxConnectors"}; }
}  // namespace

Result<std::unique_ptr<CanBus>> LinuxConnectors::can(const CanSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<I2cBus>> LinuxConnectors::i2c(const std::string&, std::string& why) { return none(why); }
Result<std::unique_ptr<SpiBus>> LinuxConnectors::spi(const SpiSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<Serial>> LinuxConnectors::serial(const SerialSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<Gpio>> LinuxConnectors::gpio(const GpioSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<Imu>> LinuxConnectors::iio_imu(const IioSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<Camera>> LinuxConnectors::v4l2_camera(const CameraSpec&, std::string& why) { return none(why); }
Result<std::unique_ptr<Camera>> LinuxConnectors::libcamera_camera(const CameraSpec&, std::string& why) {
  return none(why);
}

}  // namespace sinew::hal
