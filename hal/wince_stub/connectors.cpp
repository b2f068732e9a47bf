#include "hal/wince_stub/connectors.hpp"

namespace sinew::hal {
namespace {

Error none(const char* what, const std::string& which, std::string& why) {
  why = std::string(what) + (which.empty() ? "" : " \"" + which + "\"") +
        ": not supported on Windows CE: hal/wince_stub has no devices; those of a simulator (board = \"sim\") are";
  return {Errc::not_supported, what};
}

class NoConnectors final : public Connectors {
 public:
  Result<std::unique_ptr<CanBus>> can(const CanSpec& spec, std::string& why) override {
    return none("CAN bus", spec.address, why);
  }
  Result<std::unique_ptr<I2cBus>> i2c(const std::string& path, std::string& why) override {
    return none("I2C bus", path, why);
  }
  Result<std::unique_ptr<SpiBus>> spi(const SpiSpec& spec, std::string& why) override {
    return none("SPI bus", spec.path, why);
  }
  Result<std::unique_ptr<Serial>> serial(const SerialSpec& spec, std::string& why) override {
    return none("serial line", spec.path, why);
  }
  Result<std::unique_ptr<Gpio>> gpio(const GpioSpec& spec, std::string& why) override {
    return none("GPIO line", spec.chip + " " + spec.line, why);
  }
  Result<std::unique_ptr<Imu>> iio_imu(const IioSpec& spec, std::string& why) override {
    return none("IIO sensor", spec.name, why);
  }
  Result<std::unique_ptr<Camera>> v4l2_camera(const CameraSpec& spec, std::string& why) override {
    return none("camera", spec.path, why);
  }
  Result<std::unique_ptr<Camera>> libcamera_camera(const CameraSpec& spec, std::string& why) override {
    return none("camera", spec.path, why);
  }
  Result<std::unique_ptr<Radio>> radio(const RadioSpec& spec, std::string& why) override {
    return none("radio", to_text(spec.group), why);
  }
};

}  // namespace

std::unique_ptr<Connectors> wince_connectors() { return std::make_unique<NoConnectors>(); }

}  // namespace sinew::hal
