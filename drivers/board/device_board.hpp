#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.hpp"
#include "drivers/joints/can_buses.hpp"
#include "drivers/joints/serial_buses.hpp"

namespace sinew::drivers {

/// Every problem of form in `specs`: unknown drivers, keys, values. Nothing is opened.
std::vector<rt::Problem> check_devices(const DeviceSpecs& specs, std::span<const DriverKind> drivers);

/// The board of real devices: one for each [device.NAME] of the robot file. The driver that the table names opens the
/// device when a module or the guardian first asks for it.
/// Thread:  owner, configure only.
/// Errors:  not_found when there is no such table, or its device measures something else; the errors of opening.
///          problem() has the words.
class DeviceBoard final : public hal::Board {
 public:
  /// `specs`: check_devices() found no problems in them.
  DeviceBoard(DeviceSpecs specs, std::span<const DriverKind> drivers, hal::Connectors& connectors, hal::Os& os);
  ~DeviceBoard() override;

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override;
  hal::Result<hal::Camera*> camera(std::string_view name) override;
  hal::Result<hal::Radio*> radio(std::string_view name) override;
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;

  /// Starts the threads of the buses. Call it when all devices have been asked for, before the first cycle.
  /// Errors:  a bus that cannot carry what its joints need; problem() has it in words.
  hal::Status start();

  /// Facts about the open devices that a user should know, one a line, e.g. about a camera's pixels.
  std::string notes() const;
  /// All failures of opening so far in words, one a line, each once.
  const std::string& problem() const { return problem_; }

  /// What opening warned of although it succeeded, one a line.
  std::vector<std::string> warnings() const;
  /// Everything that is wrong now with the open devices and buses, one a line. Each line begins with the name:
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
  CanBuses can_;       // its hubs must stop before the groups that they serve are freed: hold()
  SerialBuses lines_;  // likewise
  DeviceContext context_;
  std::map<std::string, OpenedDevice, std::less<>> opened_;
  std::string problem_;
  std::vector<std::string> warnings_;
};

}  // namespace sinew::drivers
