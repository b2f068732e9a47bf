#pragma once
#include <string>
#include <string_view>

#include "hal/device.hpp"
#include "rt/module.hpp"

namespace sinew::drivers {

/// For collect(): what the device has ready goes to the raw topic, as far as its burst goes; the rest stays in the
/// device for the next cycle. A sample that the device reports as lost is counted by the board and ends the reading.
/// RT: yes.
template <class M>
void collect_ready(rt::Raw<M>& raw, hal::Sensor<M>& device) noexcept {
  while (M* sample = raw.loan()) {
    const auto got = device.read(*sample);
    if (got && *got) continue;
    raw.cancel();
    return;
  }
}

/// For configure(): says why the board does not give the device. Returns the error.
inline hal::Error explain_no_device(rt::Setup& setup, const std::string& device, const hal::Error& error) {
  setup.explain("device '" + device + "': " + hal::to_string(error.code) + " (" + error.where + ")");
  return error;
}

/// A module that asks the board for the device that its parameter `device` names. The check of a robot file uses this
/// interface; a program's own modules may implement it, too.
class DeviceReader {
 public:
  virtual ~DeviceReader() = default;
  /// What the device has to give: "imu", as DriverKind::measures has it.
  virtual std::string_view reads() const = 0;
};

}  // namespace sinew::drivers
