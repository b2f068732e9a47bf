// The object dictionary of a simulated CiA 402 drive, and its SDO server.
#include "sim_hil/wire/sim_cia402.hpp"

#include <algorithm>

namespace sinew::sim_hil {

using wire::DriveState;
using wire::ObjectAddress;
using wire::SdoAbort;

void SimCia402::add(ObjectAddress object, std::uint32_t value, std::uint8_t bytes, bool writable) {
  objects_[key(object)] = {value, bytes, writable};
}

void SimCia402::on_power() {
  objects_.clear();
  add(wire::kDeviceType, 0x00020192, 4);  // CiA 402-1: a servo drive
  add(wire::kErrorRegister, 0, 1);
  add(wire::kHeartbeatConsumer, 0, 4, true);
  add(wire::kHeartbeatProducer, 0, 2, true);
  add(wire::kVendorId, p_.vendor, 4);
  add(wire::kProductCode, p_.product, 4);
  add(wire::kRevision, p_.revision, 4);
  add(wire::kSerialNumber, p_.serial, 4);
  for (std::uint32_t n = 1; n <= 2; ++n) {
    for (const bool transmit : {false, true}) {
      const auto communication = transmit ? wire::tpdo_communication : wire::rpdo_communication;
      const auto mapping = transmit ? wire::tpdo_mapping : wire::rpdo_mapping;
      const std::uint32_t id = transmit ? wire::tpdo_id(n, p_.node_id) : wire::rpdo_id(n, p_.node_id);
      add(communication(n, 1), wire::kPdoInvalid | id, 4, true);
      add(communication(n, 2), 255, 1, true);
      for (std::uint8_t sub = 0; sub <= 4; ++sub) add(mapping(n, sub), 0, sub == 0 ? 1 : 4, true);
    }
  }
  const auto word = [this](ObjectAddress o, std::uint32_t v, bool writable) { add(o, v, 2, writable); };
  const auto wide = [this](ObjectAddress o, std::uint32_t v, bool writable) { add(o, v, 4, writable); };
  word(wire::kAbortOption, 1, true);
  word(wire::kErrorCode, 0, false);
  word(wire::kControlword, 0, true);
  word(wire::kStatusword, 0, false);
  word(wire::kQuickStopOption, 2, true);
  add(wire::kModeOfOperation, 0, 1, true);
  add(wire::kModeDisplay, 0, 1);
  wide(wire::kActualPosition, 0, false);
  wide(wire::kActualVelocity, 0, false);
  word(wire::kTargetTorque, 0, true);
  word(wire::kMaxTorque, 1000, true);
  wide(wire::kRatedTorque, static_cast<std::uint32_t>(std::lround(p_.rated_nm * 1000)), false);
  word(wire::kActualTorque, 0, false);
  wide(wire::kDcLinkVoltage, 0, false);
  wide(wire::kTargetPosition, 0, true);
  add(wire::kHomingMethod, 0, 1, true);
  add(wire::kInterpolationTime, 1, 1, true);
  add(wire::kInterpolationExponent, 0xFD, 1, true);
  wide(wire::kTargetVelocity, 0, true);
  wide(wire::kSupportedModes, 0x3A0, false);
  word(kTemperature, 250, false);
  nmt_ = wire::NmtState::boot_up;
  state_ = DriveState::switch_on_disabled;
  quick_ = homing_ = master_watched_ = false;
  control_before_ = extra_status_ = 0;
  stays_code_ = 0;
  syncs_ = 0;
}

std::uint32_t SimCia402::object(ObjectAddress object) const {
  const auto it = objects_.find(key(object));
  return it != objects_.end() ? it->second.value : 0;
}

void SimCia402::on_sdo(const wire::Sdo& request) {
  using Kind = wire::Sdo::Kind;
  if (nmt_ == wire::NmtState::stopped || request.kind == Kind::abort) return;
  if (request.kind == Kind::read_segment || (request.kind == Kind::read && request.object == wire::kDeviceName)) {
    send_name(request);
    return;
  }
  measure();
  wire::Sdo reply;
  reply.object = request.object;
  const auto it = objects_.find(key(request.object));
  bool refused = it == objects_.end();
  for (const ObjectAddress o : p_.refuses) refused = refused || o == request.object;
  if (refused) {
    reply.kind = Kind::abort;
    reply.abort_code = static_cast<std::uint32_t>(SdoAbort::no_object);
  } else if (request.kind == Kind::read) {
    reply.kind = Kind::value;
    reply.set_value(it->second.value, it->second.bytes);
  } else {
    reply.abort_code = write(request);
    reply.kind = reply.abort_code == 0 ? Kind::written : Kind::abort;
  }
  send(encode_sdo_reply(p_.node_id, reply));
}

void SimCia402::send_name(const wire::Sdo& request) {
  wire::Sdo reply;
  if (request.kind == wire::Sdo::Kind::read) {
    reply.kind = wire::Sdo::Kind::begin_segments;
    reply.object = wire::kDeviceName;
    reply.total = static_cast<std::uint32_t>(p_.name.size());
    name_at_ = 0;
    name_toggle_ = false;
  } else if (request.toggle != name_toggle_) {
    reply.kind = wire::Sdo::Kind::abort;
    reply.abort_code = static_cast<std::uint32_t>(SdoAbort::toggle);
  } else {
    reply.kind = wire::Sdo::Kind::segment;
    reply.toggle = name_toggle_;
    for (; reply.size < 7 && name_at_ < p_.name.size(); ++name_at_) {
      reply.data[reply.size++] = static_cast<std::uint8_t>(p_.name[name_at_]);
    }
    reply.last = name_at_ == p_.name.size();
    name_toggle_ = !name_toggle_;
  }
  send(encode_sdo_reply(p_.node_id, reply));
}

std::uint32_t SimCia402::write(const wire::Sdo& request) {
  Value& value = objects_[key(request.object)];
  if (!value.writable) return static_cast<std::uint32_t>(SdoAbort::read_only);
  if (request.size != value.bytes) return static_cast<std::uint32_t>(SdoAbort::length);
  const std::uint16_t index = request.object.index;
  const bool mapping = (index >= 0x1600 && index < 0x1604) || (index >= 0x1A00 && index < 0x1A04);
  if (mapping) {  // CiA 301, 7.5.2.36: only while the PDO does not exist, and it is pre-operational
    const ObjectAddress communication{static_cast<std::uint16_t>(index - 0x200), 1};
    if ((object(communication) & wire::kPdoInvalid) == 0 || nmt_ == wire::NmtState::operational) {
      return static_cast<std::uint32_t>(SdoAbort::unsupported);
    }
    const auto mapped = static_cast<std::uint32_t>(request.value() >> 8);
    const bool refused =
        std::any_of(p_.refuses.begin(), p_.refuses.end(), [&](ObjectAddress o) { return key(o) == mapped; });
    if (request.object.sub > 0 && (refused || !objects_.contains(mapped))) {
      return static_cast<std::uint32_t>(SdoAbort::cannot_be_mapped);
    }
  }
  value.value = request.value();
  if (request.object == wire::kControlword) on_controlword();
  if (request.object == wire::kHeartbeatConsumer) master_watched_ = false;
  if (request.object == wire::kModeOfOperation) extra_status_ = 0, homing_ = false;
  return 0;
}

}  // namespace sinew::sim_hil
