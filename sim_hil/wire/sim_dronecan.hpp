#pragma once
// DroneCAN actuators and ESCs, each a node of its own with one motor.
#include <string>

#include "sim_hil/wire/sim_servo.hpp"
#include "wire/dronecan_types.hpp"

namespace sinew::sim_hil {

/// Sends NodeStatus each second and its own status at a rate, follows ArrayCommand or RawCommand, answers GetNodeInfo.
/// With node_id 0 it asks for an id first, and says and does nothing else until it has one. Disarmed by ArmingStatus it
/// has no torque and follows nothing until it is armed; where no node sends ArmingStatus, commands alone are enough.
class SimDronecanServo final : public SimServo {
 public:
  struct Parameters {
    std::uint8_t node_id = 1;  // 0: asks for one
    std::uint8_t actuator_id = 0;
    bool esc = false;
    double esc_full_radps = 100;
    double kp = 60, kd = 2, most_nm = 10, kv = 0.5;  // N m/rad, N m s/rad; kv: of the speed loop, N m s/rad
    double status_hz = 100;
    Duration timeout{std::chrono::milliseconds(200)};  // without a command: no torque
    wire::DronecanUniqueId unique_id{};
    std::string name = "org.sinew.sim";
  };
  SimDronecanServo(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters);

  bool live() const override { return live_; }
  /// Health "error" with this vendor code, without torque, until power is cycled.
  void fail(std::uint32_t code) override { fault_ = code, live_ = false; }
  std::uint8_t node_id() const { return node_id_; }
  std::uint64_t commands() const { return commands_; }
  /// Reports another uptime than its own, as a second node of the same id would.
  std::uint32_t uptime_offset_s = 0;

 protected:
  void on_frame(const msg::CanFrame& frame, Time now) override;
  void on_power() override;
  double control(Time now, Duration dt) override;
  void say(Time now) override;

 private:
  void send_all(wire::DronecanId id, std::uint64_t signature, std::uint8_t transfer,
                std::span<const std::uint8_t> payload);
  void tell(const wire::DronecanWanted& type, std::uint8_t& transfer, std::span<const std::uint8_t> payload);
  void say_status();
  Duration pause();
  void ask_for_id(Time now);
  void on_allocation(const wire::DronecanTransfer& transfer, Time now);
  void on_command(const wire::DronecanTransfer& transfer, Time now);
  void on_arming(const wire::DronecanTransfer& transfer);
  std::uint8_t power_pct() const;
  wire::DronecanNodeStatus status(Time now) const;

  Parameters p_;
  wire::DronecanAssembler assembler_;
  std::uint8_t node_id_ = 0, node_transfer_ = 0, status_transfer_ = 0, ask_transfer_ = 0;
  bool live_ = false, disarmed_ = false;
  std::uint32_t fault_ = 0;
  std::uint64_t commands_ = 0;
  wire::DronecanCommandType type_ = wire::DronecanCommandType::position;
  double setpoint_ = 0;
  Time powered_at_, now_, commanded_, node_status_at_, status_at_, ask_at_;
  bool began_ = false;
  std::uint32_t random_ = 1;
  std::uint8_t known_ = 0;  // bytes of our unique id that the allocator has repeated
};

}  // namespace sinew::sim_hil
