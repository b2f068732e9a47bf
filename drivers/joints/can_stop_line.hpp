#pragma once
// Stops all joints of a robot's CAN buses without its runtime: for the parent process, when that is dead.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/joints/can_buses.hpp"
#include "drivers/joints/servo.hpp"
#include "hal/stop_line.hpp"

namespace sinew::drivers {

/// Has its own connections to the buses of the robot file's joints, and for each joint the frames that leave its drive
/// without torque in any state: ServoProtocol::farewell(). stop() sends them every 20 ms on all buses, asks between,
/// and listens until every drive has said that it is without torque, at most kPatience. A drive that does not obey for
/// half of that time gets its protocol's other way (CiA 402: NMT stop).
///
/// A CAN bus remembers nothing: a runtime that lives and sends setpoints enables its drives again. So kill the runtime
/// first, or repeat the stop when it is dead (is_latching() is false; apps/parent/parent.cpp does both).
/// Thread:  owner.   RT: stop() and poll() allocate nothing; stop() sleeps.
class CanStopLine final : public hal::StopLine {
 public:
  static constexpr hal::Duration kPatience = std::chrono::milliseconds(200);

  /// Opens the buses of the joints of these groups (`specs` without problems), each bus once. `why` names the buses
  /// that did not open; the stop uses the others all the same.
  /// Null: no bus opened, or no group has joints on a bus.
  static std::unique_ptr<CanStopLine> open(const DeviceSpecs& specs, std::span<const std::string> groups,
                                           hal::Connectors& connectors, hal::Os& os, std::string& why);

  /// Ok: each joint has said that it has no torque.
  /// Errors:  closed: no bus took a frame; timeout: not every joint has said it; last_report() names them.
  hal::Status stop() noexcept override;
  bool is_latching() const noexcept override { return false; }
  void poll() noexcept override;
  std::string last_report() const override;
  std::size_t joints() const noexcept { return joints_.size(); }

 private:
  class Bus final : public FrameSink {
   public:
    Bus(std::string name, hal::CanBus& bus, hal::Os& os) : name_(std::move(name)), bus_(bus), os_(os) {}
    void send(const msg::CanFrame& frame) noexcept override;
    std::string name_;
    hal::CanBus& bus_;
    hal::Os& os_;
    std::uint64_t sent_ = 0, refused_ = 0;  // of this stop()
    hal::Errc error_ = hal::Errc::io;       // the last refusal's
    hal::Time patient_until_;               // a full queue is waited for until then
    std::vector<hal::CanFilter> filters_;
  };
  struct Joint {
    std::string name;
    std::unique_ptr<ServoProtocol> servo;
    std::size_t bus = 0;
    TorqueSaid said = TorqueSaid::nothing;
    bool insisted = false;
  };

  CanStopLine(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os);
  bool add(const DeviceSpec& joint, std::vector<std::string>& lost);
  bool all_off() const noexcept;
  void say(int round) noexcept;
  void listen(bool believe) noexcept;
  static bool concerns(const ServoProtocol& servo, const msg::CanFrame& frame) noexcept;

  const DeviceSpecs specs_;
  hal::Os& os_;
  CanBuses can_;  // its hubs are made for what they hold, and never start
  std::vector<std::unique_ptr<Bus>> buses_;
  std::vector<Joint> joints_;
  std::vector<std::string> without_bus_;  // joints whose bus could not be opened, in words
  bool stopped_once_ = false;
};

}  // namespace sinew::drivers
