#pragma once
#include <string_view>

namespace sinew::drivers {

/// A module that asks the board for the device that its parameter `device` names: what the check of a robot file goes
/// by. Modules of a program's own that do so may say it, too.
class DeviceReader {
 public:
  virtual ~DeviceReader() = default;
  /// What the device has to give: "imu", as DriverKind::measures has it.
  virtual std::string_view reads() const = 0;
};

}  // namespace sinew::drivers
