#pragma once
// DroneCAN (UAVCAN v0) on classic CAN: identifiers, and transfers of more than one frame. dronecan_types.hpp has their
// contents. The transfer CRC has its lowest byte first.
// Source:  DroneCAN specification, "CAN bus transport layer" (identifier fields, tail byte, transfer CRC, time-outs).
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "msg/can.hpp"

namespace sinew::wire {

using msg::Time;

inline constexpr std::uint8_t kDronecanMaxNode = 127, kDronecanPriorityMax = 31;
/// The longest payload that is assembled: a GetNodeInfo response has 375 bytes.
inline constexpr std::size_t kDronecanMaxPayload = 384;

/// The 29 bits of an identifier.
struct DronecanId {
  std::uint8_t priority = 16;       // 0 goes first, 31 last
  bool service = false;             // else a message
  bool request = false;             // services: request or response
  std::uint16_t type = 0;           // data type id; services 0..255; of an anonymous message only 0..3 are carried
  std::uint8_t source = 0;          // 1..127; 0: anonymous, messages only
  std::uint8_t destination = 0;     // services: 1..127
  std::uint16_t discriminator = 0;  // anonymous: 14 bits in which two senders differ

  friend bool operator==(const DronecanId&, const DronecanId&) = default;
};
/// Fields that are too large are cut. RT: yes.
std::uint32_t dronecan_can_id(const DronecanId& id) noexcept;
/// False: a service from or to nobody.
bool dronecan_parse_id(std::uint32_t can_id, DronecanId& out) noexcept;

/// Cuts one transfer into frames; the payload stays the caller's. A transfer of up to 7 bytes is one frame; a longer
/// one begins with its CRC, which is seeded with the signature of the data type.
/// Thread:  owner.   RT: yes.
class DronecanSplitter {
 public:
  /// `transfer_id`: counted by the sender for each type (and destination), modulo 32.
  DronecanSplitter(const DronecanId& id, std::uint64_t signature, std::uint8_t transfer_id,
                   std::span<const std::uint8_t> payload) noexcept;
  /// False: all frames have been given out; also for an anonymous transfer that does not fit in one frame, which is not
  /// allowed.
  bool next(msg::CanFrame& out) noexcept;

 private:
  std::uint32_t can_id_;
  std::uint8_t transfer_id_;
  std::span<const std::uint8_t> rest_;
  std::uint16_t crc_;
  bool multi_, first_ = true, toggle_ = false, done_ = false;
};

/// A data type that a listener wants.
struct DronecanWanted {
  std::uint16_t type = 0;
  bool service = false;
  std::uint64_t signature = 0;
};

struct DronecanTransfer {
  DronecanId id;
  std::uint8_t transfer_id = 0;
  Time stamp;                             // of its first frame
  std::span<const std::uint8_t> payload;  // until the next push()
};

/// Counted since the start.
struct DronecanStats {
  std::uint64_t transfers = 0;  // complete
  std::uint64_t malformed = 0;  // frames that must not be sent: no tail, first frames that are not full, too long
  std::uint64_t crc_errors = 0, stray = 0;  // stray: a frame of no transfer that is under way, or out of its order
  std::uint64_t timed_out = 0, no_room = 0;
};

/// Assembles the frames of many senders; each sender's transfers of one type have their own place.
/// Memory:  `places` of about 400 bytes, allocated by the constructor and never again. While all are in use, a new
///          transfer of many frames is dropped and counted. Transfers of one frame need no place.
/// Thread:  owner.   RT: push() yes.
class DronecanAssembler {
 public:
  DronecanAssembler(std::span<const DronecanWanted> wanted, std::size_t places);

  enum class Heard : std::uint8_t {
    foreign,   // no DroneCAN frame, a type that nobody wants, or a service for another node
    partial,   // part of a transfer
    complete,  // `out` is a whole one
    broken     // counted in stats()
  };
  /// `own_node`: only services for this node are taken; 0: none. A transfer whose frames take longer than two seconds
  /// is given up. `now` never goes backwards.
  /// up. `now` never goes backwards.
  Heard push(const msg::CanFrame& frame, Time now, std::uint8_t own_node, DronecanTransfer& out) noexcept;
  const DronecanStats& stats() const noexcept { return stats_; }

 private:
  struct Place {
    bool busy = false, toggle = false;
    std::uint8_t transfer_id = 0;
    std::uint16_t said_crc = 0;
    std::uint32_t can_id = 0;
    Time begun, stamp;
    std::uint64_t signature = 0;
    std::size_t size = 0;
    std::uint8_t data[kDronecanMaxPayload];
  };
  const DronecanWanted* wanted(const DronecanId& id) const noexcept;
  Place* find(std::uint32_t can_id) noexcept;
  Place* free_place(Time now) noexcept;
  Heard begin(const msg::CanFrame& frame, std::uint64_t signature, Time now) noexcept;
  Heard go_on(const msg::CanFrame& frame, const DronecanId& id, Time now, DronecanTransfer& out) noexcept;

  std::vector<DronecanWanted> wanted_;
  std::vector<Place> places_;
  DronecanStats stats_;
};

/// The transfer CRC starts with the signature's bytes, lowest first. RT: yes.
std::uint16_t dronecan_crc_seed(std::uint64_t signature) noexcept;

}  // namespace sinew::wire
