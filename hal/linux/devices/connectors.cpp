#include "hal/linux/devices/connectors.hpp"

#include "hal/linux/camera/libcamera_plugin.hpp"
#include "hal/linux/camera/v4l2_camera.hpp"
#include "hal/linux/camera/v4l2_tree_port.hpp"
#include "hal/linux/can/can.hpp"
#include "hal/linux/devices/gpio.hpp"
#include "hal/linux/devices/i2c.hpp"
#include "hal/linux/devices/iio_imu.hpp"
#include "hal/linux/devices/net_radio.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/linux/devices/spi.hpp"
#include "hal/linux/grab/grab_camera.hpp"
#include "hal/linux/image_server/image_server_camera.hpp"
#include "hal/linux/udp_radio.hpp"

namespace sinew::hal {

Result<std::unique_ptr<Connectors>> LinuxConnectors::open(Os& os, std::string& why) {
  auto watch = FdWatch::start(os, {"devices", kDeviceWatchPriority, {}, std::size_t{64} * 1024});
  if (!watch) {
    why = "the thread that watches the devices does not start";
    return watch.error();
  }
  return std::unique_ptr<Connectors>(new LinuxConnectors(os, std::move(*watch)));
}

std::unique_ptr<Connectors> LinuxConnectors::unwatched(Os& os) {
  return std::unique_ptr<Connectors>(new LinuxConnectors(os, FdWatch::none()));
}

Result<std::unique_ptr<CanBus>> LinuxConnectors::can(const CanSpec& spec, std::string& why) {
  return open_can(spec, os_, watch_, why);
}
Result<std::unique_ptr<I2cBus>> LinuxConnectors::i2c(const std::string& path, std::string& why) {
  return open_i2c(path, why);
}
Result<std::unique_ptr<SpiBus>> LinuxConnectors::spi(const SpiSpec& spec, std::string& why) {
  return open_spi(spec, why);
}
Result<std::unique_ptr<Serial>> LinuxConnectors::serial(const SerialSpec& spec, std::string& why) {
  return open_serial(spec, why);
}
Result<std::unique_ptr<Gpio>> LinuxConnectors::gpio(const GpioSpec& spec, std::string& why) {
  return open_gpio(spec, why);
}
Result<std::unique_ptr<Imu>> LinuxConnectors::iio_imu(const IioSpec& spec, std::string& why) {
  return open_iio_imu(os_, spec, why);
}
Result<std::unique_ptr<Camera>> LinuxConnectors::v4l2_camera(const CameraSpec& spec, std::string& why) {
  std::unique_ptr<V4l2Port>* tree = spec.root == "/" ? nullptr : &trees_[spec.root];
  if (tree && !*tree) *tree = std::make_unique<V4l2TreePort>(os_, spec.root);
  auto camera = V4l2Camera::open(tree ? **tree : kernel_v4l2_port(), spec, os_, watch_, {}, why);
  if (!camera) return camera.error();
  return std::unique_ptr<Camera>(std::move(*camera));
}
Result<std::unique_ptr<Camera>> LinuxConnectors::libcamera_camera(const CameraSpec& spec, std::string& why) {
  return open_libcamera_plugin(spec, os_, why);
}
Result<std::unique_ptr<Camera>> LinuxConnectors::grab_camera(const GrabSpec& spec, std::string& why) {
  return GrabCamera::open(spec, os_, why);
}
Result<std::unique_ptr<Camera>> LinuxConnectors::image_server_camera(const ImageServerSpec& spec, std::string& why) {
  return ImageServerCamera::open(spec, os_, why);
}
Result<std::unique_ptr<Radio>> LinuxConnectors::radio(const RadioSpec& spec, std::string& why) {
  return spec.net.empty() ? UdpRadio::open(spec, os_, why) : NetRadio::open(spec.net, os_, why);
}

}  // namespace sinew::hal
