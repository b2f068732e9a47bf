#pragma once
// Motors that close their loop on position, velocity, gains and torque: MIT frames and CyberGear.
#include "sim_hil/wire/sim_servo.hpp"
#include "wire/cybergear.hpp"
#include "wire/mit_motor.hpp"

namespace sinew::sim_hil {

/// What both have in common: the impedance loop, over-temperature, and the motor's own time-out.
class SimImpedance : public SimServo {
 public:
  using SimServo::SimServo;
  bool live() const override { return live_; }
  void fail(std::uint32_t code) override { fault_ = code, live_ = false; }
  /// The cause of a fault stays: clearing does not help.
  bool fault_stays = false;

 protected:
  double control(Time now, Duration dt) override;
  void on_power() override;
  void say(Time) override {}
  void clear() {
    if (!fault_stays && temperature_c <= hot_c_) fault_ = 0;
  }
  virtual std::uint32_t hot_code() const = 0;

  double most_nm_ = 18, hot_c_ = 100;
  Duration timeout_{0};  // without a command; 0: none
  bool live_ = false;
  std::uint32_t fault_ = 0;
  wire::MitCommand command_;
  Time commanded_{};
  double zero_ = 0;
};

class SimMitMotor final : public SimImpedance {
 public:
  struct Parameters {
    std::uint32_t motor = 1, master = 0;
    wire::MitMotorType type;
    Duration timeout{std::chrono::milliseconds(100)};
  };
  SimMitMotor(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters);

 protected:
  void on_frame(const msg::CanFrame& frame, Time now) override;
  std::uint32_t hot_code() const override { return p_.type.reply == wire::MitReply::status ? 0xB : 1; }

 private:
  Parameters p_;
};

class SimCyberGear final : public SimImpedance {
 public:
  struct Parameters {
    std::uint32_t motor = 1;
    std::uint64_t serial = 0xC0FFEE;
  };
  SimCyberGear(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters);

 protected:
  void on_frame(const msg::CanFrame& frame, Time now) override;
  void on_power() override;
  std::uint32_t hot_code() const override { return 4; }

 private:
  void reply(std::uint32_t host);
  void on_parameter(const msg::CanFrame& frame, const wire::CyberGearId& id);

  Parameters p_;
};

}  // namespace sinew::sim_hil
