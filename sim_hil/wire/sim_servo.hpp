#pragma once
// Simulated drives, and servos as they are on a CAN bus, with the same codecs as the drivers: for tests, and for a
// robot on real buses whose joints are simulated.
#include <cmath>
#include <memory>
#include <vector>

#include "hal/can_bus.hpp"
#include "wire/can_bytes.hpp"

namespace sinew::sim_hil {

using hal::Duration;
using hal::Time;

/// The joint that a simulated drive moves. A physics engine implements it with its own joint; JointModel needs no
/// engine.
/// Frames:  the joint's own.
class SimJoint {
 public:
  virtual ~SimJoint() = default;
  virtual double position_rad() const = 0;
  virtual double velocity_radps() const = 0;
  /// Until the next call.
  virtual void set_effort(double nm) = 0;
  /// Time goes on; a physics engine that moves the joint itself does nothing here.
  virtual void advance(Duration dt) = 0;
};

/// A wheel with friction between two stops.
class JointModel final : public SimJoint {
 public:
  struct Parameters {
    double inertia_kgm2 = 0.01, damping_nmspr = 0.05, min_rad = -12, max_rad = 12;
  };
  JointModel() = default;
  explicit JointModel(const Parameters& parameters) : p_(parameters) {}
  double position_rad() const override { return position_rad_; }
  double velocity_radps() const override { return velocity_radps_; }
  void set_effort(double nm) override { effort_nm_ = nm; }
  void advance(Duration dt) override;
  void place(double rad) { position_rad_ = rad, velocity_radps_ = 0; }

 private:
  Parameters p_;
  double position_rad_ = 0, velocity_radps_ = 0, effort_nm_ = 0;
};

/// How the drive sits on its joint, as drivers::ServoConfig: drive_rad = sign * gear_ratio * (joint_rad + zero_rad).
struct SimMount {
  double sign = 1, gear_ratio = 1, zero_rad = 0;
};

/// Faults of a simulated servo, set at any time between calls.
struct SimServoFaults {
  bool silent = false;   // hears and acts, but says nothing
  bool garbage = false;  // says nonsense under its identifiers
  bool stuck = false;    // neither moves nor measures anew, but talks
  double lost = 0;       // part of its frames that do not arrive, either way: 0..1
};

/// A drive on its joint, without its bus: power, faults, and the torque that moves the joint.
/// Thread:  owner.
class SimDrive {
 public:
  SimDrive(SimJoint& joint, const SimMount& mount) : joint_(joint), mount_(mount) {}
  virtual ~SimDrive() = default;
  SimDrive(const SimDrive&) = delete;
  SimDrive& operator=(const SimDrive&) = delete;

  /// Moves the joint up to `now` in steps of at most a millisecond, and sends what is due.
  void advance(Time now);
  /// Off: gone from the bus, without torque. On again: as after power-up.
  void power(bool on);
  bool powered() const { return powered_; }
  /// The drive reports a fault of its own; the protocol defines `code`. The fault holds until the master clears it.
  virtual void fail(std::uint32_t code) = 0;

  SimServoFaults faults;
  double temperature_c = 25, voltage_v = 24;
  /// The torque at the drive, and whether it has any; for tests.
  double effort_nm() const { return effort_nm_; }
  virtual bool live() const = 0;

 protected:
  virtual void on_power() = 0;
  /// The torque for the next `dt`, drive side; time has reached `now` before.
  virtual double control(Time now, Duration dt) = 0;
  /// What is due by time.
  virtual void say(Time now) = 0;

  double drive_position() const;
  double drive_velocity() const;
  double drive_effort() const { return faults.stuck ? stuck_effort_ : effort_nm_; }
  double chance();  // 0..1, the same sequence in every run

 private:
  SimJoint& joint_;
  SimMount mount_;
  bool powered_ = true, started_ = false;
  Time now_{};
  double effort_nm_ = 0;
  double stuck_position_ = 0, stuck_velocity_ = 0, stuck_effort_ = 0;
  std::uint64_t random_ = 0x9E3779B97F4A7C15;
};

/// One servo on a CAN bus. The owner gives it the frames of its bus and moves time on.
/// Thread:  owner.
class SimServo : public SimDrive {
 public:
  SimServo(hal::CanBus& bus, SimJoint& joint, const SimMount& mount) : SimDrive(joint, mount), bus_(bus) {}
  void receive(const msg::CanFrame& frame, Time now);

 protected:
  virtual void on_frame(const msg::CanFrame& frame, Time now) = 0;
  void send(msg::CanFrame frame);

 private:
  hal::CanBus& bus_;
};

/// The servos behind one port of a bus: reads it, gives each frame to each of them, moves them on.
class SimServos {
 public:
  explicit SimServos(hal::CanBus& bus) : bus_(bus) {}
  template <class Servo, class... Args>
  Servo& add(SimJoint& joint, const SimMount& mount, Args&&... args) {
    auto servo = std::make_unique<Servo>(bus_, joint, mount, std::forward<Args>(args)...);
    Servo& it = *servo;
    servos_.push_back(std::move(servo));
    return it;
  }
  void poll(Time now);

 private:
  hal::CanBus& bus_;
  std::vector<std::unique_ptr<SimServo>> servos_;
};

}  // namespace sinew::sim_hil
