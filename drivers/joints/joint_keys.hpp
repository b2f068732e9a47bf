#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/device_keys.hpp"
#include "drivers/joints/can_buses.hpp"
#include "drivers/joints/servo.hpp"

namespace sinew::drivers {

/// One [[device.NAME.joint]]: which bus, and what makes its protocol there.
struct JointConfig {
  std::string bus, protocol;
  ServoConfig servo;
  std::uint32_t replies_as = 0;  // mit: the identifier of its answers
  /// Makes the protocol, and what it shares with others on the bus when that is not there yet.
  std::function<std::unique_ptr<ServoProtocol>(BusPlace&)> make;
};

/// What a joint's `driver` may be: cia402, mit, cybergear, dronecan.
std::span<const std::string_view> joint_protocols();

/// Reads a joint's keys; its `driver` is the protocol. Problems: of each key, of keys beside each other, and beside
/// those of the bus.
JointConfig read_joint(DeviceKeys& keys, const DeviceSpecs& specs);

}  // namespace sinew::drivers
