#pragma once
#include "drivers/driver.hpp"
#include "drivers/joints/joint_keys.hpp"

namespace sinew::drivers {

/// driver = "can_servos": a group of joints, actuators and sensor in one.
DeviceOpener read_can_servos(DeviceKeys& keys, const DeviceSpecs& specs);
/// driver = "serial_servos": the same on half-duplex serial lines.
DeviceOpener read_serial_servos(DeviceKeys& keys, const DeviceSpecs& specs);
/// driver = "joints_of": the sensor of a group under another name.
DeviceOpener read_joints_of(DeviceKeys& keys, const DeviceSpecs& specs);

}  // namespace sinew::drivers
