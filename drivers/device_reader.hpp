#pragma once
#include <string_view>

namespace sinew::drivers {

/// A module that asks the board for the device that its parameter `device` names. The check of a robot file uses this
/// interface; a program's own modules may implement it, too.
class DeviceReader {
 public:
  virtual ~DeviceReader() = default;
  /// What the device has to give: "imu", as DriverKind::measures has it.
  virtual std::string_view reads() const = 0;
};

}  // namespace sinew::drivers
