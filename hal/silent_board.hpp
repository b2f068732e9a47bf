#pragma once
#include <limits>

#include "hal/board.hpp"
#include "hal/camera_controls.hpp"

namespace sinew::hal {

/// Opens every device, by any name, with nothing behind it: no device is ever ready, and commands are accepted and
/// dropped. For graphs that must not touch devices: a record that is executed again.
class SilentBoard final : public Board {
 public:
  Result<Device*> open_sensor(SensorKind kind, std::string_view) override {
    switch (kind) {
      case SensorKind::imu:
        return &imu_;
      case SensorKind::range:
        return &range_;
      case SensorKind::baro:
        return &baro_;
      case SensorKind::battery:
        return &battery_;
      case SensorKind::mag:
        return &mag_;
      case SensorKind::gnss:
        return &gnss_;
      case SensorKind::rc:
        return &rc_;
      case SensorKind::joints:
        return &joints_;
      case SensorKind::text:
        return &text_;
      case SensorKind::soles:
        return &soles_;
      case SensorKind::referee:
        return &referee_;
    }
    return Error{Errc::not_found, "a kind of sensor"};
  }
  Result<Camera*> camera(std::string_view) override { return &camera_; }
  Result<Radio*> radio(std::string_view) override { return &radio_; }
  Result<Actuators*> actuators(std::string_view) override { return &actuators_; }

 private:
  template <class Interface, class M>
  class SilentSensor : public Interface {
   public:
    Result<bool> read(M&) noexcept override { return false; }
    Time ready_at() const noexcept override { return kNever; }
    void set_wake(Wake*) noexcept override {}
  };
  /// Takes any exposure and gain: the camera of the record allowed the recorded values.
  class SilentCamera final : public SilentSensor<Camera, msg::Image>, public CameraControls {
   public:
    const std::vector<CameraControl>& controls() const override { return controls_; }
    Status request(std::size_t, double) noexcept override { return {}; }
    std::optional<Exposure> exposure() const override { return Exposure{0, std::chrono::microseconds(1), {}, 0}; }
    std::optional<std::size_t> gain() const override { return 1; }

   private:
    static constexpr double kAny = std::numeric_limits<double>::max();
    const std::vector<CameraControl> controls_{{"exposure_us", -kAny, kAny}, {"gain", -kAny, kAny}};
  };
  /// Hears nobody, and what it sends reaches nobody.
  class SilentRadio final : public SilentSensor<Radio, msg::Datagram> {
   public:
    Status send(std::span<const std::uint8_t>) noexcept override { return {}; }
    RadioStats stats() const noexcept override { return {}; }
  };
  class SilentActuators final : public Actuators {
   public:
    Status write(const msg::ActuatorCommand&, Duration) noexcept override { return {}; }
    Status stop() noexcept override { return {}; }
  };
  SilentSensor<Imu, msg::ImuSample> imu_;
  SilentSensor<Range, msg::RangeSample> range_;
  SilentSensor<Baro, msg::BaroSample> baro_;
  SilentSensor<Battery, msg::BatterySample> battery_;
  SilentSensor<Mag, msg::MagSample> mag_;
  SilentSensor<Gnss, msg::GnssSample> gnss_;
  SilentSensor<Rc, msg::RcSample> rc_;
  SilentSensor<Joints, msg::JointState> joints_;
  SilentSensor<TextRobot, msg::TextValues> text_;
  SilentSensor<Soles, msg::SolePressure> soles_;
  SilentSensor<Referee, msg::RefereeState> referee_;
  SilentCamera camera_;
  SilentRadio radio_;
  SilentActuators actuators_;
};

}  // namespace sinew::hal
