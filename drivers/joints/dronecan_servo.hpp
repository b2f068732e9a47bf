#pragma once
#include "drivers/joints/dronecan_node.hpp"
#include "drivers/joints/servo_check.hpp"
#include "drivers/joints/servo_joint.hpp"

namespace sinew::drivers {

struct DronecanServoOptions {
  bool esc = false;           // esc.RawCommand and esc.Status; else actuator.ArrayCommand and actuator.Status
  double esc_full_radps = 0;  // drive speed at the full command of 8191; ESCs have no other unit
  double status_hz = 50;      // how often it tells its status, for the bus load
};
/// Empty: fine.
WrongKeys check_dronecan(const ServoConfig& config, const DronecanServoOptions& options);

/// A DroneCAN actuator or ESC: ServoConfig::node_id is its node, actuator_id its place in the commands.
///
/// The protocol knows neither enabling nor disabling. Setpoints enable a joint. No setpoints (actuators: position),
/// speed 0, force 0, or command 0 (ESCs) switch it off. ArmingStatus says for the whole bus whether anything may move,
/// to devices that heed it. The device's own setting decides what it does then, and when it hears nothing, so
/// check_dronecan() allows only the stop action that each mode really has:
/// position: hold; velocity: damp (speed 0); effort and ESCs: torque_off.
/// Feedback: actuators: position, velocity, effort. ESCs: velocity, temperature, voltage; no position (NaN).
/// Derating: lowers an ESC's fastest speed, as it has no effort limit; actuators report no temperature.
/// Faults:  NodeStatus: health error or critical, or not operational: kJointOther with the vendor's code. A restarted
///          node has to be enabled again; uptime that goes back without a restart: two nodes of one id.
/// Homing:  zero_here moves our offset; home: there is none. Identity: GetNodeInfo.
/// Thread, RT: as ServoProtocol.
class DronecanServo final : public ServoProtocol {
 public:
  /// `node`: the service of the same bus; outlives this.
  DronecanServo(const ServoConfig& config, const DronecanServoOptions& options, DronecanNode& node);

  std::span<const Interest> interests() const override { return interests_; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame& frame, Time now) noexcept override;
  void tick(Time now, const ServoCommand& command, FrameSink& out) noexcept override;
  const ServoFeedback& feedback() const noexcept override { return shown_; }
  const ServoIdentity& identity() const noexcept override { return identity_; }
  const ServoStats& stats() const noexcept override { return joint_.stats(); }
  const ServoConfig& config() const noexcept override { return joint_.config(); }
  std::string_view shares() const noexcept override { return options_.esc ? "esc" : "actuator"; }
  void farewell(FrameSink& out) noexcept override;
  /// Off: a status with power 0 %. Actuators may not know their power; they never say it then.
  TorqueSaid torque_said(const msg::CanFrame& frame, Time now) noexcept override;

 private:
  bool on_status(const wire::DronecanTransfer& transfer, Time now) noexcept;
  bool on_node_status(const wire::DronecanTransfer& transfer, Time now) noexcept;
  bool on_info(const wire::DronecanTransfer& transfer) noexcept;
  void ask_identity(Time now, FrameSink& out) noexcept;
  void command(double joint_value) noexcept;
  template <class Message>
  void say(const wire::DronecanWanted& type, const Message& message, FrameSink& out) const noexcept;
  void command_stop() noexcept;
  void show() noexcept;

  ServoJoint joint_;
  DronecanServoOptions options_;
  DronecanNode& node_;
  std::array<Interest, 3> interests_{};
  wire::DronecanAssembler assembler_;
  ServoIdentity identity_;
  ServoFeedback shown_;  // the joint's, without a position where there is none
  BackOff ask_;
  std::uint8_t ask_transfer_ = 0, farewell_transfer_ = 0;
  bool on_ = false, heard_status_ = false;
  std::uint32_t uptime_s_ = 0, request_seen_ = 0;
  Time status_at_{}, ahead_at_{};  // the last node status, and the last one that was too far ahead of it
};

}  // namespace sinew::drivers
