#pragma once
// How joint_keys.cpp and joint_protocol_keys.cpp read one joint between them.
#include <initializer_list>
#include <utility>

#include "drivers/joints/joint_keys.hpp"
#include "drivers/joints/mit_servo.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "drivers/joints/servo_check.hpp"

namespace sinew::drivers {

inline constexpr double kMostRad = 1e6, kMostNm = 1e5, kMostRadps = 1e5;

/// One joint's table, the bus that it names, and what comes of both.
class JointReader {
 public:
  JointReader(DeviceKeys& keys, const DeviceSpecs& specs) : keys_(keys), specs_(specs) {
    c_.name = keys.spec().name;
    joint_.protocol = keys.spec().driver;
  }
  JointConfig read();

 private:
  using Stops = std::initializer_list<std::pair<std::string_view, StopAction>>;

  void read_bus();
  void read_place(std::int64_t most_id, Stops stops, std::string_view stop_doc);
  void read_frame();
  void read_limits();
  void read_watches(std::string_view usual_following);
  void read_gains();
  void read_device_timeout();
  void read_cia402();
  void read_mit();
  void read_mit_ranges(MitOptions& o, bool custom);
  void read_cybergear();
  void read_dronecan();
  void read_serial(wire::ServoMaker maker);
  void refuse(const WrongKeys& wrong);
  Pace tick() const;

  DeviceKeys& keys_;
  const DeviceSpecs& specs_;
  const DeviceSpec* bus_spec_ = nullptr;
  CanBusConfig bus_;
  SerialBusConfig line_;  // of a joint on a serial line
  JointConfig joint_;
  ServoConfig c_;
};

}  // namespace sinew::drivers
