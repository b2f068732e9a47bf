#include "wire/canopen.hpp"

#include <algorithm>

namespace sinew::wire {

CanopenId canopen_id(std::uint32_t id) {
  const std::uint32_t function = id & 0x780, node = id & 0x7F;
  if (id > 0x7FF) return {};
  if (id == kNmtId) return {CanopenKind::nmt, 0, 0};
  if (id == kSyncId) return {CanopenKind::sync, 0, 0};
  if (id == 0x100) return {CanopenKind::time, 0, 0};
  if (node == 0) return {};
  switch (function) {
    case 0x080:
      return {CanopenKind::emergency, node, 0};
    case 0x580:
      return {CanopenKind::sdo_reply, node, 0};
    case 0x600:
      return {CanopenKind::sdo_request, node, 0};
    case 0x700:
      return {CanopenKind::heartbeat, node, 0};
    default:
      break;
  }
  if (function < 0x180 || function > 0x500) return {};
  const bool to_device = (function & 0x80) == 0;
  return {to_device ? CanopenKind::rpdo : CanopenKind::tpdo, node, to_device ? (function >> 8) - 1 : function >> 8};
}

msg::CanFrame encode_nmt(NmtCommand command, std::uint32_t node) {
  return can_frame(kNmtId, {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(node)});
}

std::optional<Nmt> decode_nmt(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || frame.id != kNmtId || frame.size != 2 || frame.data[1] > kMaxCanopenNode) return {};
  switch (const auto command = static_cast<NmtCommand>(frame.data[0])) {
    case NmtCommand::start:
    case NmtCommand::stop:
    case NmtCommand::pre_operational:
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      return Nmt{command, frame.data[1]};
  }
  return {};
}

msg::CanFrame encode_heartbeat(std::uint32_t node, NmtState state) {
  return can_frame(heartbeat_id(node), {static_cast<std::uint8_t>(state)});
}

std::optional<NmtState> decode_heartbeat(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || canopen_id(frame.id).kind != CanopenKind::heartbeat || frame.size != 1) return {};
  switch (const auto state = static_cast<NmtState>(frame.data[0] & 0x7F)) {
    case NmtState::boot_up:
    case NmtState::stopped:
    case NmtState::operational:
    case NmtState::pre_operational:
      return state;
  }
  return {};
}

msg::CanFrame encode_emergency(std::uint32_t node, const Emergency& emergency) {
  msg::CanFrame frame = can_frame(emergency_id(node), 8);
  put_le(frame, 0, emergency.code);
  frame.data[2] = emergency.error_register;
  for (std::size_t i = 0; i < 5; ++i) frame.data[3 + i] = emergency.vendor[i];
  return frame;
}

std::optional<Emergency> decode_emergency(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || canopen_id(frame.id).kind != CanopenKind::emergency || frame.size != 8) return {};
  Emergency e;
  e.code = get_le<std::uint16_t>(frame, 0);
  e.error_register = frame.data[2];
  for (std::size_t i = 0; i < 5; ++i) e.vendor[i] = frame.data[3 + i];
  return e;
}

const char* to_string(SdoAbort code) {
  switch (code) {
    case SdoAbort::toggle:
      return "toggle bit did not alternate";
    case SdoAbort::timeout:
      return "SDO timed out";
    case SdoAbort::command:
      return "SDO command is not known";
    case SdoAbort::unsupported:
      return "access is not supported";
    case SdoAbort::write_only:
      return "object can only be written";
    case SdoAbort::read_only:
      return "object can only be read";
    case SdoAbort::no_object:
      return "no such object";
    case SdoAbort::cannot_be_mapped:
      return "object cannot be mapped to a PDO";
    case SdoAbort::pdo_too_long:
      return "more than a PDO holds";
    case SdoAbort::length:
      return "length does not fit the object";
    case SdoAbort::no_sub_index:
      return "no such sub-index";
    case SdoAbort::range:
      return "value is out of range";
    case SdoAbort::general:
      return "general error";
    case SdoAbort::device_state:
      return "not in this state of the device";
  }
  return "unknown abort code";
}

Sdo sdo_read(ObjectAddress object) {
  Sdo sdo;
  sdo.kind = Sdo::Kind::read;
  sdo.object = object;
  return sdo;
}

Sdo sdo_write(ObjectAddress object, std::uint32_t value, std::uint8_t bytes) {
  Sdo sdo;
  sdo.kind = Sdo::Kind::write;
  sdo.object = object;
  sdo.set_value(value, bytes);
  return sdo;
}

namespace {

void put_object(msg::CanFrame& frame, ObjectAddress object) {
  put_le(frame, 1, object.index);
  frame.data[3] = object.sub;
}
ObjectAddress get_object(const msg::CanFrame& frame) { return {get_le<std::uint16_t>(frame, 1), frame.data[3]}; }

/// Expedited data, one to four bytes; `specifier` is the upper three bits.
void put_expedited(msg::CanFrame& frame, const Sdo& sdo, std::uint8_t specifier) {
  const auto size = std::clamp<std::uint8_t>(sdo.size, 1, 4);
  frame.data[0] = static_cast<std::uint8_t>(specifier | (4 - size) << 2 | 3);
  put_object(frame, sdo.object);
  for (std::size_t i = 0; i < size; ++i) frame.data[4 + i] = sdo.data[i];
}
void get_expedited(const msg::CanFrame& frame, Sdo& sdo) {
  sdo.object = get_object(frame);
  const bool size_said = (frame.data[0] & 1) != 0;
  sdo.size = static_cast<std::uint8_t>(size_said ? 4 - (frame.data[0] >> 2 & 3) : 4);
  for (std::size_t i = 0; i < sdo.size; ++i) sdo.data[i] = frame.data[4 + i];
}
void put_abort(msg::CanFrame& frame, const Sdo& sdo) {
  frame.data[0] = 0x80;
  put_object(frame, sdo.object);
  put_le(frame, 4, sdo.abort_code);
}
Sdo get_abort(const msg::CanFrame& frame) {
  Sdo sdo;
  sdo.kind = Sdo::Kind::abort;
  sdo.object = get_object(frame);
  sdo.abort_code = get_le<std::uint32_t>(frame, 4);
  return sdo;
}

}  // namespace

msg::CanFrame encode_sdo_request(std::uint32_t node, const Sdo& sdo) {
  msg::CanFrame frame = can_frame(sdo_request_id(node), 8);
  if (sdo.kind == Sdo::Kind::write) {
    put_expedited(frame, sdo, 0x20);
  } else if (sdo.kind == Sdo::Kind::read_segment) {
    frame.data[0] = sdo.toggle ? 0x70 : 0x60;
  } else if (sdo.kind == Sdo::Kind::abort) {
    put_abort(frame, sdo);
  } else {
    frame.data[0] = 0x40;
    put_object(frame, sdo.object);
  }
  return frame;
}

msg::CanFrame encode_sdo_reply(std::uint32_t node, const Sdo& sdo) {
  msg::CanFrame frame = can_frame(sdo_reply_id(node), 8);
  if (sdo.kind == Sdo::Kind::value) {
    put_expedited(frame, sdo, 0x40);
  } else if (sdo.kind == Sdo::Kind::begin_segments) {
    frame.data[0] = sdo.total > 0 ? 0x41 : 0x40;
    put_object(frame, sdo.object);
    put_le(frame, 4, sdo.total);
  } else if (sdo.kind == Sdo::Kind::segment) {
    const std::uint8_t size = sdo.size > 7 ? 7 : sdo.size;
    frame.data[0] = static_cast<std::uint8_t>((sdo.toggle ? 0x10 : 0) | (7 - size) << 1 | (sdo.last ? 1 : 0));
    for (std::size_t i = 0; i < size; ++i) frame.data[1 + i] = sdo.data[i];
  } else if (sdo.kind == Sdo::Kind::written) {
    frame.data[0] = 0x60;
    put_object(frame, sdo.object);
  } else {
    put_abort(frame, sdo);
  }
  return frame;
}

std::optional<Sdo> decode_sdo_request(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || frame.size != 8) return {};
  const std::uint8_t command = frame.data[0];
  Sdo sdo;
  switch (command >> 5) {
    case 1:                               // initiate download
      if ((command & 2) == 0) return {};  // in segments: not here
      sdo.kind = Sdo::Kind::write;
      get_expedited(frame, sdo);
      return sdo;
    case 2:
      return sdo_read(get_object(frame));
    case 3:
      sdo.kind = Sdo::Kind::read_segment;
      sdo.toggle = (command & 0x10) != 0;
      return sdo;
    case 4:
      return get_abort(frame);
    default:
      return {};
  }
}

std::optional<Sdo> decode_sdo_reply(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || frame.size != 8) return {};
  const std::uint8_t command = frame.data[0];
  Sdo sdo;
  switch (command >> 5) {
    case 0:
      sdo.kind = Sdo::Kind::segment;
      sdo.toggle = (command & 0x10) != 0;
      sdo.last = (command & 1) != 0;
      sdo.size = static_cast<std::uint8_t>(7 - (command >> 1 & 7));
      for (std::size_t i = 0; i < sdo.size; ++i) sdo.data[i] = frame.data[1 + i];
      return sdo;
    case 2:
      if ((command & 2) != 0) {
        sdo.kind = Sdo::Kind::value;
        get_expedited(frame, sdo);
      } else {
        sdo.kind = Sdo::Kind::begin_segments;
        sdo.object = get_object(frame);
        sdo.total = (command & 1) != 0 ? get_le<std::uint32_t>(frame, 4) : 0;
      }
      return sdo;
    case 3:
      sdo.kind = Sdo::Kind::written;
      sdo.object = get_object(frame);
      return sdo;
    case 4:
      return get_abort(frame);
    default:
      return {};
  }
}

}  // namespace sinew::wire
