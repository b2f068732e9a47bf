#pragma once
// What a driver is to its board: how it reads its keys, and what it opens.
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/device_keys.hpp"
#include "drivers/device_spec.hpp"
#include "hal/board.hpp"
#include "hal/connectors.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"

namespace sinew::drivers {

class CanBuses;
class SerialBuses;

/// One opened [device.NAME]: any of these interfaces, kept alive by `owner`.
struct OpenedDevice {
  std::shared_ptr<void> owner;
  std::array<hal::Device*, hal::kSensorKinds> sensors{};  // by SensorKind
  hal::Camera* camera = nullptr;
  hal::Radio* radio = nullptr;
  hal::Actuators* actuators = nullptr;
  const hal::SelfReport* report = nullptr;  // null: it has no words for itself

  hal::Device*& sensor(hal::SensorKind kind) { return sensors[static_cast<std::size_t>(kind)]; }
};

/// What a driver opens its device with.
struct DeviceContext {
  hal::Connectors& connectors;
  hal::Os& os;
  CanBuses& can;
  SerialBuses& lines;
  /// Another device of the board. Errors: those of its opening, which the board reports itself; `why` names the device.
  std::function<hal::Result<OpenedDevice*>(std::string_view name, std::string& why)> device;
};

/// Opens a device whose keys have been read. `why` has the failure in words.
using DeviceOpener = std::function<hal::Result<OpenedDevice>(DeviceContext&, std::string& why)>;

/// One driver that a robot file can name.
struct DriverKind {
  std::string_view name;      // driver = "iio"
  std::string_view measures;  // for people: "imu"
  /// Reads one table. `specs`: all tables, as one may name another.
  DeviceOpener (*read)(DeviceKeys& keys, const DeviceSpecs& specs);
};

}  // namespace sinew::drivers
