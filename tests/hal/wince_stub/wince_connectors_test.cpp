#include "hal/wince_stub/connectors.hpp"

#include <gtest/gtest.h>

namespace sinew::hal::wince_connectors_test {
namespace {

TEST(WinceConnectors, EveryDeviceIsRefusedWithItsNameAndWhatThereIsInstead) {
  const auto plugs = wince_connectors();
  std::string why;
  const auto refused = [&](const auto& opened, const char* name) {
    EXPECT_EQ(opened.error().code, Errc::not_supported) << why;
    EXPECT_NE(why.find(name), std::string::npos) << why;
    EXPECT_NE(why.find("board = \"sim\""), std::string::npos) << why;
  };
  refused(plugs->can({.transport = "socketcand", .address = "can7"}, why), "can7");
  refused(plugs->i2c("/dev/i2c-3", why), "/dev/i2c-3");
  refused(plugs->spi({.path = "/dev/spidev0.0"}, why), "/dev/spidev0.0");
  refused(plugs->serial({.path = "COM1:"}, why), "COM1:");
  refused(plugs->gpio({.chip = "chip0", .line = "KILL"}, why), "KILL");
  IioSpec imu;
  imu.name = "mpu6050";
  refused(plugs->iio_imu(imu, why), "mpu6050");
  CameraSpec camera;
  camera.path = "/dev/video0";
  refused(plugs->v4l2_camera(camera, why), "/dev/video0");
  refused(plugs->libcamera_camera(camera, why), "/dev/video0");
}

}  // namespace
}  // namespace sinew::hal::wince_connectors_test
