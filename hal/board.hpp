#pragma once
#include <string_view>

#include "hal/device.hpp"
#include "hal/radio.hpp"

namespace sinew::hal {

/// The source of devices: the real kernel, a simulator's sockets, a recorded folder. A board owns its devices, which
/// live as long as the board. Names are those of the robot file ("imu", "camera", "motors").
/// Thread:  owner, configure only.
/// Errors:  not_found when the board has no such device; not_supported; those of opening.
class Board {
 public:
  virtual ~Board() = default;
  /// The sensor that measures messages of type M: `board.sensor<msg::ImuSample>("imu")`.
  template <class M>
  Result<Sensor<M>*> sensor(std::string_view name) {
    auto device = open_sensor(kSensorKind<M>, name);
    if (!device) return device.error();
    return static_cast<Sensor<M>*>(*device);
  }
  /// Answers a Sensor<M> with kSensorKind<M> == kind.
  virtual Result<Device*> open_sensor(SensorKind kind, std::string_view name) = 0;
  virtual Result<Camera*> camera(std::string_view name) = 0;
  virtual Result<Radio*> radio(std::string_view name) = 0;
  virtual Result<Actuators*> actuators(std::string_view name) = 0;
};

/// A board without devices: graphs that need none, and tests.
class EmptyBoard : public Board {
 public:
  Result<Device*> open_sensor(SensorKind, std::string_view) override { return none(); }
  Result<Camera*> camera(std::string_view) override { return none(); }
  Result<Radio*> radio(std::string_view) override { return none(); }
  Result<Actuators*> actuators(std::string_view) override { return none(); }

 private:
  static Error none() { return {Errc::not_found, "this board has no devices"}; }
};

/// Says how far virtual time may run. The discrete-event executor runs everything up to the grant, then asks again.
class GrantSource {
 public:
  virtual ~GrantSource() = default;
  /// Reports the work done since the last call (`done_to` is reached, commands have been written to the Actuators of
  /// the same board) and waits until all samples due by the returned time are delivered.
  /// Errors:  closed when the plant ended the run; bad_data, timeout.
  virtual Result<Time> next_grant(Time done_to) = 0;
};

/// Grants everything up to a fixed end at once: virtual time without a plant.
class FixedGrant final : public GrantSource {
 public:
  explicit FixedGrant(Time end) : end_(end) {}
  Result<Time> next_grant(Time done_to) override {
    if (done_to >= end_) return Error{Errc::closed, "end of run"};
    return end_;
  }

 private:
  Time end_;
};

}  // namespace sinew::hal
