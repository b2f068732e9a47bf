#pragma once
#include "hal/connectors.hpp"

namespace sinew::drivers::test {

/// A machine without any plug.
class NoConnectors : public hal::Connectors {
 public:
  hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec&, std::string& why) override { return none(why); }
  hal::Result<std::unique_ptr<hal::I2cBus>> i2c(const std::string&, std::string& why) override { return none(why); }
  hal::Result<std::unique_ptr<hal::SpiBus>> spi(const hal::SpiSpec&, std::string& why) override { return none(why); }
  hal::Result<std::unique_ptr<hal::Serial>> serial(const hal::SerialSpec&, std::string& why) override {
    return none(why);
  }
  hal::Result<std::unique_ptr<hal::Gpio>> gpio(const hal::GpioSpec&, std::string& why) override { return none(why); }
  hal::Result<std::unique_ptr<hal::Imu>> iio_imu(const hal::IioSpec&, std::string& why) override { return none(why); }
  hal::Result<std::unique_ptr<hal::Camera>> v4l2_camera(const hal::CameraSpec&, std::string& why) override {
    return none(why);
  }
  hal::Result<std::unique_ptr<hal::Camera>> libcamera_camera(const hal::CameraSpec&, std::string& why) override {
    return none(why);
  }
  hal::Result<std::unique_ptr<hal::Radio>> radio(const hal::RadioSpec&, std::string& why) override { return none(why); }

 private:
  static hal::Error none(std::string& why) {
    why = "/dev/nothing: no such file";
    return {hal::Errc::not_found, "NoConnectors"};
  }
};

}  // namespace sinew::drivers::test
