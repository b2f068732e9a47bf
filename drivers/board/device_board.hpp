#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.hpp"
#include "drivers/joints/can_buses.hpp"

namespace sinew::drivers {

/// Every problem of form in `specs`: unknown drivers, keys, values. Nothing is opened.
std::vector<rt::Problem> check_devices(const DeviceSpecs& specs, std::span<const DriverKind> drivers);

/// The board of real devices: those of the robot file's [device.NAME], each opened when a module or the guardian first
/// asks for it, by the driver that its table names.
/// Thread:  owner, configure only.
/// Errors:  not_found when there is no such table, or its device measures something else; what opening said. problem()
///          has it in words.
class DeviceBoard final : public hal::Board {
 public:
  /// `specs` without problems.
  DeviceBoard(DeviceSpecs specs, std::span<const DriverKind> drivers, hal::Connectors& connectors, hal::Os& os);
  ~DeviceBoard() override;

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override;
  hal::Result<hal::Camera*> camera(std::string_view name) override;
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;

  /// When all devices have been asked for, before the first cycle: the threads of the buses start.
  /// Errors:  a bus that cannot carry what its joints need; problem() has it in words.
  hal::Status start();

  /// How the devices that are open work, where a user should know, one a line: a camera's pixels.
  std::string notes() const;
  /// All failures of opening so far in words, one a line, each once.
  const std::string& problem() const { return problem_; }

  /// What opening warned of although it succeeded, one a line.
  std::vector<std::string> warnings() const;
  /// What is wrong now with any device or bus that was opened, one a line, which begins with its name:
  /// "head.tilt (cia402 2 on can0): absent". Thread: any, from start() until the board goes. RT: no.
  std::vector<std::string> complaints() const;
  /// Threads of devices and buses that run without what they asked for (SCHED_FIFO), one a line. From start() on.
  std::vector<std::string> shortfalls() const;

 private:
  hal::Result<OpenedDevice*> open(std::string_view name, std::string& why);
  OpenedDevice* find(std::string_view name, hal::Error& error);
  void tell(const std::string& what);
  hal::Error is_no(std::string_view name, std::string_view what);

  DeviceSpecs specs_;
  std::span<const DriverKind> drivers_;
  CanBuses can_;  // before what its hubs serve is let go, they have to stop: hold()
  DeviceContext context_;
  std::map<std::string, OpenedDevice, std::less<>> opened_;
  std::string problem_;
  std::vector<std::string> warnings_;
};

}  // namespace sinew::drivers
