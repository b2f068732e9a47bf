#pragma once
#include <functional>
#include <memory>
#include <string>

#include "drivers/can_buses.hpp"
#include "drivers/device_board.hpp"
#include "drivers/servo.hpp"

namespace sinew::drivers {

/// One [[device.NAME.joint]]: which bus, and what makes its protocol there.
struct JointConfig {
  std::string bus, protocol;
  ServoConfig servo;
  /// Makes the protocol, and what it shares with others on the bus when that is not there yet.
  std::function<std::unique_ptr<ServoProtocol>(BusPlace&)> make;
};

/// Reads a joint's keys; its `driver` is the protocol: cia402, mit, cybergear, dronecan.
JointConfig read_joint(DeviceKeys& keys, const DeviceSpecs& specs);

/// driver = "can_servos": a group of joints, actuators and sensor in one.
DeviceOpener read_can_servos(DeviceKeys& keys, const DeviceSpecs& specs);
/// driver = "joints_of": the sensor of a group under another name.
DeviceOpener read_joints_of(DeviceKeys& keys, const DeviceSpecs& specs);

}  // namespace sinew::drivers
