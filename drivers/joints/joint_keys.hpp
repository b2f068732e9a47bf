#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/device_keys.hpp"
#include "drivers/joints/can_buses.hpp"
#include "drivers/joints/serial_servo.hpp"
#include "drivers/joints/servo.hpp"

namespace sinew::drivers {

/// One [[device.NAME.joint]]: its bus, and the function that makes its protocol there.
struct JointConfig {
  std::string bus, protocol;
  ServoConfig servo;
  std::uint32_t replies_as = 0;  // mit: the identifier of its answers
  /// Makes the protocol, and the service that it shares on the bus when the bus has none yet.
  std::function<std::unique_ptr<ServoProtocol>(BusPlace&)> make;
  /// Of a joint on a serial line, instead.
  bool serial = false;
  std::function<std::unique_ptr<SerialServo>()> make_serial;
};

/// What a joint's `driver` may be: cia402, mit, cybergear, dronecan, dynamixel, feetech.
std::span<const std::string_view> joint_protocols();

/// Reads a joint's keys; its `driver` is the protocol. Finds problems of each key, of keys that do not fit each other,
/// and of keys that do not fit the bus's.
JointConfig read_joint(DeviceKeys& keys, const DeviceSpecs& specs);

}  // namespace sinew::drivers
