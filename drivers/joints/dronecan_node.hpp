#pragma once
// Our own node on a DroneCAN bus: all DroneCAN servos of the bus share it.
#include <array>
#include <optional>
#include <vector>

#include "drivers/joints/servo.hpp"
#include "wire/dronecan_types.hpp"

namespace sinew::drivers {

struct DronecanNodeConfig {
  std::uint8_t node_id = 10;   // 1..127, ours
  std::string name = "sinew";  // what GetNodeInfo tells, at most 80
  wire::DronecanUniqueId unique_id{};
  /// Node ids for nodes that ask for one, by their unique id. A node that is not in here gets none.
  struct Allocated {
    wire::DronecanUniqueId unique_id{};
    std::uint8_t node_id = 0;
  };
  std::vector<Allocated> allocation;
};
/// Empty: fine. Otherwise what is wrong, in words.
std::string check_dronecan_node(const DronecanNodeConfig& config);

struct DronecanNodeStats {
  std::uint64_t info_requests = 0, answers = 0, answers_dropped = 0;  // dropped: one was still going out
  std::uint64_t allocated = 0, allocation_unknown = 0;                // nodes that are not in the table
  std::uint64_t own_id_heard = 0;                                     // somebody else uses our node id
  wire::DronecanStats transfers;
};

/// Sends NodeStatus each second, and ArmingStatus twice a second and on change (armed: any servo of the bus is live;
/// some devices move only then, and all of these stop without). Answers GetNodeInfo, gives node ids by its table, and
/// sends one ArrayCommand and one RawCommand a tick with the values that the servos left. An answer of many frames goes
/// out over several ticks.
/// Lease:   a value that no servo sets in a tick is not sent: actuators fall back by their own time-out. In RawCommand,
///          whose places are counted, an index that no servo set is 0: stop.
/// Source:  DroneCAN specification, "Node discovery", "Dynamic node id allocation" (three requests of 6, 6 and 4 bytes
///          of unique id; a gap of more than 500 ms begins anew).
/// Thread, RT: as BusService.
class DronecanNode final : public BusService {
 public:
  explicit DronecanNode(const DronecanNodeConfig& config);

  // ---- for servos ----
  std::uint8_t id() const noexcept { return config_.node_id; }
  /// Called once by each actuator, before the start: the bus load is planned for it.
  void join_actuator() { ++actuators_; }
  /// Before the start, too: the node of this unique id gets `node_id` when it asks for one.
  void allocate(const wire::DronecanUniqueId& unique_id, std::uint8_t node_id);
  void join_esc(std::size_t index) { escs_ = index + 1 > escs_ ? index + 1 : escs_; }
  /// For this tick. A transfer holds 15 actuators; the others go into another one.
  void set_actuator(std::uint8_t actuator_id, wire::DronecanCommandType type, double value) noexcept;
  void set_esc(std::size_t index, std::int16_t command) noexcept;
  /// In this tick a servo is live: devices that wait for ArmingStatus may move.
  void set_armed() noexcept { armed_ = true; }
  /// A transfer of one frame by us, as a request for GetNodeInfo is.
  void send_short(const wire::DronecanId& id, std::uint64_t signature, std::uint8_t transfer,
                  std::span<const std::uint8_t> payload, FrameSink& out) const noexcept;

  std::span<const Interest> interests() const override { return interests_; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame& frame, Time now) noexcept override;
  void begin(Time now, FrameSink& out) noexcept override;
  void end(Time now, FrameSink& out) noexcept override;
  /// Thread: the hub's.
  DronecanNodeStats stats() const noexcept;

 private:
  void say_status(Time now, FrameSink& out) noexcept;
  void listen_for_askers();
  void say_armed(Time now, FrameSink& out) noexcept;
  void send_all(const wire::DronecanWanted& type, std::uint8_t priority, std::uint8_t& transfer,
                std::span<const std::uint8_t> payload, FrameSink& out) noexcept;
  bool answer(const wire::DronecanId& id, std::uint64_t signature, std::uint8_t transfer, std::size_t size) noexcept;
  Heard on_info_request(const wire::DronecanTransfer& transfer) noexcept;
  Heard on_allocation(const wire::DronecanTransfer& transfer, Time now) noexcept;
  void give(Time now) noexcept;

  DronecanNodeConfig config_;
  std::vector<Interest> interests_;
  wire::DronecanAssembler assembler_;
  wire::DronecanNodeInfo info_;
  DronecanNodeStats stats_;
  Time started_, status_at_;
  bool begun_ = false, armed_ = false, said_armed_ = false;
  Time armed_at_;
  std::uint8_t arming_transfer_ = 0, status_transfer_ = 0, actuator_transfer_ = 0, esc_transfer_ = 0,
               allocation_transfer_ = 0;

  static constexpr std::size_t kMaxActuators = 60;
  std::size_t actuators_ = 0, escs_ = 0;
  std::array<wire::DronecanActuatorCommand::One, kMaxActuators> commands_{};
  std::size_t command_count_ = 0;
  wire::DronecanEscRawCommand raw_;

  std::array<std::uint8_t, wire::kDronecanMaxPayload> answer_bytes_{};
  std::optional<wire::DronecanSplitter> answer_;

  wire::DronecanUniqueId asked_{};  // by a node without an id, so far
  std::size_t asked_size_ = 0;
  Time asked_at_;
};

}  // namespace sinew::drivers
