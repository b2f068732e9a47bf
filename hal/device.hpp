#pragma once
// Devices as modules see them: non-blocking, stamped, in SI units. They hide bus and kernel.
#include "hal/clock.hpp"
#include "hal/result.hpp"
#include "msg/actuators.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "msg/referee.hpp"
#include "msg/sensors.hpp"
#include "msg/text_values.hpp"

namespace sinew::hal {

/// A party to wake when a device has data; the executor implements it.
class Wake {
 public:
  virtual ~Wake() = default;
  /// Thread:  any.   RT: yes; enters the kernel only when a thread sleeps.
  virtual void wake() noexcept = 0;
};

/// The interface of every device.
class Device {
 public:
  virtual ~Device() = default;
  /// The earliest instant at which read() will return something, as far as is known: a time at or before now means
  /// "ready", kNever "nothing announced". Boards on virtual time know all samples up to the grant.
  virtual Time ready_at() const noexcept = 0;
  /// Sets the party to wake when data arrives: before the start. Null (no more calls): at any time.
  virtual void set_wake(Wake* wake) noexcept = 0;
};

/// A device that measures messages of type M.
template <class M>
class Sensor : public Device {
 public:
  /// Moves the oldest waiting sample into `out`. False: nothing is ready (normal); `out` is then unspecified.
  /// Thread:  owner.   RT: yes, never blocks.
  /// Errors:  closed when the device is gone; io, bad_data when this sample was lost (the next call goes on).
  virtual Result<bool> read(M& out) noexcept = 0;
};

using Imu = Sensor<msg::ImuSample>;
using Range = Sensor<msg::RangeSample>;
using Baro = Sensor<msg::BaroSample>;
using Battery = Sensor<msg::BatterySample>;
using Mag = Sensor<msg::MagSample>;
using Gnss = Sensor<msg::GnssSample>;
using Rc = Sensor<msg::RcSample>;
using Joints = Sensor<msg::JointState>;
using Soles = Sensor<msg::SolePressure>;
using Referee = Sensor<msg::RefereeState>;
using TextRobot = Sensor<msg::TextValues>;

/// The quantity that a sensor measures, for look-ups by name; kSensorKind<M> is that of Sensor<M>.
enum class SensorKind : std::uint8_t { imu, range, baro, battery, mag, gnss, rc, joints, text, soles, referee };
inline constexpr std::size_t kSensorKinds = 11;
const char* to_string(SensorKind kind);
template <class M>
inline constexpr SensorKind kSensorKind = M::no_sensor_measures_this;
template <>
inline constexpr SensorKind kSensorKind<msg::ImuSample> = SensorKind::imu;
template <>
inline constexpr SensorKind kSensorKind<msg::RangeSample> = SensorKind::range;
template <>
inline constexpr SensorKind kSensorKind<msg::BaroSample> = SensorKind::baro;
template <>
inline constexpr SensorKind kSensorKind<msg::BatterySample> = SensorKind::battery;
template <>
inline constexpr SensorKind kSensorKind<msg::MagSample> = SensorKind::mag;
template <>
inline constexpr SensorKind kSensorKind<msg::GnssSample> = SensorKind::gnss;
template <>
inline constexpr SensorKind kSensorKind<msg::RcSample> = SensorKind::rc;
template <>
inline constexpr SensorKind kSensorKind<msg::JointState> = SensorKind::joints;
template <>
inline constexpr SensorKind kSensorKind<msg::TextValues> = SensorKind::text;
template <>
inline constexpr SensorKind kSensorKind<msg::SolePressure> = SensorKind::soles;
template <>
inline constexpr SensorKind kSensorKind<msg::RefereeState> = SensorKind::referee;

/// A camera. read() describes `out` with format_as() and fills its pixels, at most one pass over them.
/// Errors of read(): bad_argument when the frame does not fit the capacity of `out` (the frame is dropped).
class Camera : public Sensor<msg::Image> {};

/// The actuators' behaviour when their setpoints end while the permission lasts: `own` is the device's safe action for
/// the end of a lease (damp, hold, a ramp, off), `limp` no torque.
enum class FallBack : std::uint8_t { own, limp };

/// A group of actuators that act together (e.g. four motors).
class Actuators {
 public:
  virtual ~Actuators() = default;
  /// Hands over setpoints that are valid for `lease` from now on; after that the device falls back to its safe action.
  /// Thread:  owner (the guardian).   RT: yes, never blocks.
  /// Errors:  closed, io; the previous setpoints then run out with their lease.
  virtual Status write(const msg::ActuatorCommand& command, Duration lease) noexcept = 0;
  /// Stops at once (motors off, torque off): disarmed, killed, or the end of the run.
  virtual Status stop() noexcept = 0;
  /// Ends the lease at once: the last setpoints are no longer valid. A group that was stopped stays stopped. Devices
  /// whose only safe action is off need not override it.
  virtual Status fall_back(FallBack) noexcept { return stop(); }
};

}  // namespace sinew::hal
