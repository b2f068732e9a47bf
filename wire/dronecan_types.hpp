#pragma once
// The DroneCAN data types that we use. encode() returns the bytes written, 0 when they do not fit; decode() returns
// false when the payload is too short or has a value that the type does not allow. Both: RT yes. Bytes and bits are
// ordered as in dronecan_bits.hpp: lowest byte first, in each byte the highest bit first.
// Source:  dronecan/DSDL; each struct names its file. Signatures follow from the definitions (tests compute them).
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "wire/dronecan.hpp"

namespace sinew::wire {

inline constexpr DronecanWanted kDronecanNodeStatus{341, false, 0x0F0868D0C1A7C6F1};
inline constexpr DronecanWanted kDronecanGetNodeInfo{1, true, 0xEE468A8121C46A9E};
inline constexpr DronecanWanted kDronecanAllocation{1, false, 0x0B2A812620A11D40};
inline constexpr DronecanWanted kDronecanEscRawCommand{1030, false, 0x217F5C87D7EC951D};
inline constexpr DronecanWanted kDronecanEscStatus{1034, false, 0xA9AF28AEA2FBB254};
inline constexpr DronecanWanted kDronecanActuatorCommand{1010, false, 0xD8A7486238EC3AF3};
inline constexpr DronecanWanted kDronecanActuatorStatus{1011, false, 0x5E9BBA44FAF1EA04};
inline constexpr DronecanWanted kDronecanArmingStatus{1100, false, 0x8700F375556A8003};

using Payload = std::span<const std::uint8_t>;

enum class DronecanHealth : std::uint8_t { ok, warning, error, critical };
enum class DronecanMode : std::uint8_t {
  operational = 0,
  initialization = 1,
  maintenance = 2,
  update = 3,
  offline = 7
};

/// uavcan/protocol/341.NodeStatus: each node, at least once a second.
struct DronecanNodeStatus {
  std::uint32_t uptime_s = 0;
  DronecanHealth health = DronecanHealth::ok;
  std::uint8_t mode = 0;  // DronecanMode; 4..6 are reserved and kept as they are
  std::uint8_t sub_mode = 0;
  std::uint16_t vendor_code = 0;
};
std::size_t encode(const DronecanNodeStatus& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanNodeStatus& out) noexcept;

using DronecanUniqueId = std::array<std::uint8_t, 16>;

/// uavcan/protocol/1.GetNodeInfo, the response; the request is empty. A certificate is skipped and never sent.
struct DronecanNodeInfo {
  DronecanNodeStatus status;
  std::uint8_t software_major = 0, software_minor = 0;
  std::uint8_t software_flags = 0;  // 1: vcs_commit is valid, 2: image_crc
  std::uint32_t vcs_commit = 0;
  std::uint64_t image_crc = 0;
  std::uint8_t hardware_major = 0, hardware_minor = 0;
  DronecanUniqueId unique_id{};
  std::array<char, 80> name_text{};
  std::uint8_t name_size = 0;

  std::string_view name() const { return {name_text.data(), name_size}; }
  void set_name(std::string_view name) noexcept;  // cut at 80
};
std::size_t encode(const DronecanNodeInfo& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanNodeInfo& out) noexcept;

/// uavcan/protocol/dynamic_node_id/1.Allocation.
struct DronecanAllocation {
  std::uint8_t node_id = 0;  // wished or given; 0: any
  bool first_part = false;
  std::array<std::uint8_t, 16> unique_id{};
  std::uint8_t size = 0;  // bytes of unique_id
};
std::size_t encode(const DronecanAllocation& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanAllocation& out) noexcept;

/// uavcan/equipment/esc/1030.RawCommand: -8192..8191 for each ESC, by its index; 0 stops it.
struct DronecanEscRawCommand {
  std::array<std::int16_t, 20> command{};
  std::uint8_t count = 0;
};
inline constexpr std::int16_t kDronecanEscFull = 8191;
std::size_t encode(const DronecanEscRawCommand& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanEscRawCommand& out) noexcept;

/// uavcan/equipment/esc/1034.Status. NaN where the ESC does not measure it.
struct DronecanEscStatus {
  std::uint32_t error_count = 0;
  double voltage_v = 0, current_a = 0, temperature_k = 0;
  std::int32_t rpm = 0;        // 18 bits
  std::uint8_t power_pct = 0;  // 0..127
  std::uint8_t esc_index = 0;  // 0..31
};
std::size_t encode(const DronecanEscStatus& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanEscStatus& out) noexcept;

enum class DronecanCommandType : std::uint8_t { unitless, position, force, speed, pwm };

/// uavcan/equipment/actuator/1010.ArrayCommand. Rad or m, N m or N, rad/s or m/s; unitless -1..1.
struct DronecanActuatorCommand {
  struct One {
    std::uint8_t actuator_id = 0;
    std::uint8_t type = 0;  // DronecanCommandType; others are kept as they are
    double value = 0;
  };
  std::array<One, 15> command{};
  std::uint8_t count = 0;
};
std::size_t encode(const DronecanActuatorCommand& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanActuatorCommand& out) noexcept;

/// uavcan/equipment/actuator/1011.Status. NaN: not measured.
struct DronecanActuatorStatus {
  std::uint8_t actuator_id = 0;
  double position = 0, force = 0, speed = 0;  // rad or m, N m or N, rad/s or m/s
  std::uint8_t power_pct = 127;               // 127: unknown
};
std::size_t encode(const DronecanActuatorStatus& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanActuatorStatus& out) noexcept;

/// uavcan/equipment/safety/1100.ArmingStatus: 255 fully armed, 0 disarmed; values between are no permission either.
struct DronecanArmingStatus {
  bool armed = false;
};
std::size_t encode(const DronecanArmingStatus& in, std::span<std::uint8_t> out) noexcept;
bool decode(Payload in, DronecanArmingStatus& out) noexcept;

}  // namespace sinew::wire
