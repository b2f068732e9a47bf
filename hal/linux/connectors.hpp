#pragma once
#include "hal/connectors.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/self_report.hpp"

namespace sinew::hal {

/// The kernel's buses, ports and devices. One thread watches all their descriptors.
/// Thread:  owner, configure only. What it opened is gone before this is.
/// SCHED_FIFO of the thread that watches all descriptors: an interrupt thread, above every module that waits for a
/// device.
inline constexpr int kDeviceWatchPriority = 95;

class LinuxConnectors final : public Connectors, public SelfReport {
 public:
  static Result<std::unique_ptr<Connectors>> open(Os& os, std::string& why);

  Result<std::unique_ptr<CanBus>> can(const CanSpec& spec, std::string& why) override;
  Result<std::unique_ptr<I2cBus>> i2c(const std::string& path, std::string& why) override;
  Result<std::unique_ptr<SpiBus>> spi(const SpiSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Serial>> serial(const SerialSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Gpio>> gpio(const GpioSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Imu>> iio_imu(const IioSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> v4l2_camera(const CameraSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> libcamera_camera(const CameraSpec& spec, std::string& why) override;

  std::string trouble() const override { return {}; }  // what it opened tells for itself
  std::string shortfall() const override { return watch_->shortfall(); }

 private:
  LinuxConnectors(Os& os, std::shared_ptr<FdWatch> watch) : os_(os), watch_(std::move(watch)) {}
  Os& os_;
  std::shared_ptr<FdWatch> watch_;
};

}  // namespace sinew::hal
