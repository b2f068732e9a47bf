#pragma once
#include "hal/board.hpp"

namespace sinew::hal {

/// Opens every device, by any name, and there is nothing behind it: nothing is ever ready, and whatever is commanded is
/// taken and forgotten. For graphs whose devices are not to be touched: a record that is executed again.
class SilentBoard final : public Board {
 public:
  Result<Imu*> imu(std::string_view) override { return &imu_; }
  Result<Range*> range(std::string_view) override { return &range_; }
  Result<Baro*> baro(std::string_view) override { return &baro_; }
  Result<Battery*> battery(std::string_view) override { return &battery_; }
  Result<Camera*> camera(std::string_view) override { return &camera_; }
  Result<Actuators*> actuators(std::string_view) override { return &actuators_; }

 private:
  template <class Interface, class M>
  class SilentSensor final : public Interface {
   public:
    Result<bool> read(M&) noexcept override { return false; }
    Time ready_at() const noexcept override { return kNever; }
    void set_wake(Wake*) noexcept override {}
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
  SilentSensor<Camera, msg::Image> camera_;
  SilentActuators actuators_;
};

}  // namespace sinew::hal
