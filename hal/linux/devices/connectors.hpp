#pragma once
#include <map>

#include "hal/connectors.hpp"
#include "hal/linux/camera/v4l2_port.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/self_report.hpp"

namespace sinew::hal {

/// SCHED_FIFO of the thread that watches all descriptors: an interrupt thread, above every module that waits for a
/// device.
inline constexpr int kDeviceWatchPriority = 95;

/// The kernel's buses, ports and devices. One thread watches all their descriptors.
/// Thread:  owner, configure only. Destroy the opened objects before this one.
class LinuxConnectors final : public Connectors, public SelfReport {
 public:
  static Result<std::unique_ptr<Connectors>> open(Os& os, std::string& why);
  /// For a caller that polls its devices: they wake no thread, and no thread watches.
  static std::unique_ptr<Connectors> unwatched(Os& os);

  Result<std::unique_ptr<CanBus>> can(const CanSpec& spec, std::string& why) override;
  Result<std::unique_ptr<I2cBus>> i2c(const std::string& path, std::string& why) override;
  Result<std::unique_ptr<SpiBus>> spi(const SpiSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Serial>> serial(const SerialSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Gpio>> gpio(const GpioSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Imu>> iio_imu(const IioSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> v4l2_camera(const CameraSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> libcamera_camera(const CameraSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> grab_camera(const GrabSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Camera>> image_server_camera(const ImageServerSpec& spec, std::string& why) override;
  Result<std::unique_ptr<Radio>> radio(const RadioSpec& spec, std::string& why) override;

  std::string trouble() const override { return {}; }  // the opened objects report for themselves
  std::string shortfall() const override { return watch_->shortfall(); }

 private:
  LinuxConnectors(Os& os, std::shared_ptr<FdWatch> watch) : os_(os), watch_(std::move(watch)) {}
  Os& os_;
  std::shared_ptr<FdWatch> watch_;
  std::map<std::string, std::unique_ptr<V4l2Port>> trees_;  // simulated ones, by their folders
};

}  // namespace sinew::hal
