#pragma once
// CANopen on classic CAN frames: NMT, SYNC, EMCY, heartbeat, PDO and SDO. Numbers are little-endian (CiA 301, 7.1.4).
// Source:  CiA 301 version 4.2.0: 7.2.8 (NMT), 7.2.5 (SYNC), 7.2.7 (EMCY), 7.2.4 (SDO), 7.3.3 (predefined connection
//          set).
#include <optional>

#include "wire/can_bytes.hpp"

namespace sinew::wire {

inline constexpr std::uint32_t kMaxCanopenNode = 127;

/// What an 11-bit identifier means in the predefined connection set.
enum class CanopenKind : std::uint8_t {
  nmt,
  sync,
  time,
  emergency,
  tpdo,  // from a device
  rpdo,  // to a device
  sdo_reply,
  sdo_request,
  heartbeat,
  other
};
struct CanopenId {
  CanopenKind kind = CanopenKind::other;
  std::uint32_t node = 0;    // 1..127; 0 for nmt, sync, time, other
  std::uint32_t number = 0;  // of the PDO, 1..4
};
CanopenId canopen_id(std::uint32_t id);

constexpr std::uint32_t kNmtId = 0x000, kSyncId = 0x080;
constexpr std::uint32_t emergency_id(std::uint32_t node) { return 0x080 + node; }
constexpr std::uint32_t tpdo_id(std::uint32_t number, std::uint32_t node) { return 0x080 + 0x100 * number + node; }
constexpr std::uint32_t rpdo_id(std::uint32_t number, std::uint32_t node) { return 0x100 + 0x100 * number + node; }
constexpr std::uint32_t sdo_reply_id(std::uint32_t node) { return 0x580 + node; }
constexpr std::uint32_t sdo_request_id(std::uint32_t node) { return 0x600 + node; }
constexpr std::uint32_t heartbeat_id(std::uint32_t node) { return 0x700 + node; }

// ---- network management ----

enum class NmtCommand : std::uint8_t {
  start = 1,
  stop = 2,
  pre_operational = 128,
  reset_node = 129,
  reset_communication = 130
};
/// `node` 0: all.
msg::CanFrame encode_nmt(NmtCommand command, std::uint32_t node);
struct Nmt {
  NmtCommand command;
  std::uint32_t node;
};
std::optional<Nmt> decode_nmt(const msg::CanFrame& frame);

enum class NmtState : std::uint8_t { boot_up = 0, stopped = 4, operational = 5, pre_operational = 127 };
msg::CanFrame encode_heartbeat(std::uint32_t node, NmtState state);
/// Of any node; the toggle bit of node guarding is ignored.
std::optional<NmtState> decode_heartbeat(const msg::CanFrame& frame);

inline msg::CanFrame encode_sync() { return can_frame(kSyncId, 0); }

/// `code` 0: the error is over.
struct Emergency {
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;  // object 1001h
  std::array<std::uint8_t, 5> vendor{};
};
msg::CanFrame encode_emergency(std::uint32_t node, const Emergency& emergency);
std::optional<Emergency> decode_emergency(const msg::CanFrame& frame);

// ---- service data objects ----

struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  friend bool operator==(const ObjectAddress&, const ObjectAddress&) = default;
};

enum class SdoAbort : std::uint32_t {
  toggle = 0x05030000,
  timeout = 0x05040000,
  command = 0x05040001,
  unsupported = 0x06010000,
  write_only = 0x06010001,
  read_only = 0x06010002,
  no_object = 0x06020000,
  cannot_be_mapped = 0x06040041,
  pdo_too_long = 0x06040042,
  length = 0x06070010,
  no_sub_index = 0x06090011,
  range = 0x06090030,
  general = 0x08000000,
  device_state = 0x08000022
};
/// Plain words; "unknown abort code" where CiA 301 has none.
const char* to_string(SdoAbort code);

/// One SDO frame, in either direction. Writing more than four bytes at once is not part of this.
struct Sdo {
  enum class Kind : std::uint8_t {
    read,            // request: value of `object`
    write,           // request: `size` bytes of `data` into `object`
    read_segment,    // request: the next piece
    value,           // reply: `size` bytes of `data`
    begin_segments,  // reply: the value comes in pieces; `total` bytes, 0: not said
    segment,         // reply: up to seven bytes; `last`
    written,         // reply
    abort,           // either: `abort_code`
  };
  Kind kind = Kind::read;
  ObjectAddress object;
  std::uint8_t size = 0;
  bool toggle = false, last = false;
  std::array<std::uint8_t, 7> data{};
  std::uint32_t total = 0, abort_code = 0;

  std::uint32_t value() const {  // of up to four bytes
    return static_cast<std::uint32_t>(data[0] | data[1] << 8 | data[2] << 16) | static_cast<std::uint32_t>(data[3])
                                                                                    << 24;
  }
  void set_value(std::uint32_t v, std::uint8_t bytes) {
    size = bytes;
    for (std::size_t i = 0; i < 4; ++i) data[i] = i < bytes ? static_cast<std::uint8_t>(v >> (8 * i)) : std::uint8_t{0};
  }
};
Sdo sdo_read(ObjectAddress object);
Sdo sdo_write(ObjectAddress object, std::uint32_t value, std::uint8_t bytes);

msg::CanFrame encode_sdo_request(std::uint32_t node, const Sdo& sdo);
msg::CanFrame encode_sdo_reply(std::uint32_t node, const Sdo& sdo);
/// Nothing: not eight bytes, or a command that is not known here.
std::optional<Sdo> decode_sdo_request(const msg::CanFrame& frame);
std::optional<Sdo> decode_sdo_reply(const msg::CanFrame& frame);

// ---- objects of the communication profile (CiA 301, 7.5.2) ----

constexpr ObjectAddress kDeviceType{0x1000, 0}, kErrorRegister{0x1001, 0}, kDeviceName{0x1008, 0},
    kHeartbeatConsumer{0x1016, 1}, kHeartbeatProducer{0x1017, 0}, kVendorId{0x1018, 1}, kProductCode{0x1018, 2},
    kRevision{0x1018, 3}, kSerialNumber{0x1018, 4};
/// Communication (sub 1 COB-ID, 2 transmission type, 5 event timer) and mapping of PDO `number` 1..4.
constexpr ObjectAddress rpdo_communication(std::uint32_t number, std::uint8_t sub) {
  return {static_cast<std::uint16_t>(0x13FF + number), sub};
}
constexpr ObjectAddress rpdo_mapping(std::uint32_t number, std::uint8_t sub) {
  return {static_cast<std::uint16_t>(0x15FF + number), sub};
}
constexpr ObjectAddress tpdo_communication(std::uint32_t number, std::uint8_t sub) {
  return {static_cast<std::uint16_t>(0x17FF + number), sub};
}
constexpr ObjectAddress tpdo_mapping(std::uint32_t number, std::uint8_t sub) {
  return {static_cast<std::uint16_t>(0x19FF + number), sub};
}
constexpr std::uint32_t kPdoInvalid = 0x80000000;  // bit of the COB-ID: this PDO does not exist
/// An entry of a PDO mapping.
constexpr std::uint32_t mapped(ObjectAddress object, std::uint32_t bits) {
  return std::uint32_t{object.index} << 16 | std::uint32_t{object.sub} << 8 | bits;
}

}  // namespace sinew::wire
