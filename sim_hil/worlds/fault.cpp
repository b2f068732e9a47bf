#include "sim_hil/worlds/fault.hpp"

#include <algorithm>

namespace sinew::plant {

std::string_view to_string(FaultDevice device) {
  switch (device) {
    case FaultDevice::imu:
      return "imu";
    case FaultDevice::range:
      return "range";
    case FaultDevice::baro:
      return "baro";
    case FaultDevice::battery:
      return "battery";
    case FaultDevice::camera:
      return "camera";
    case FaultDevice::motors:
      return "motors";
    case FaultDevice::link:
      return "link";
    case FaultDevice::joints:
      return "joints";
    case FaultDevice::head:
      return "head";
    case FaultDevice::radio:
      return "radio";
    case FaultDevice::soles:
      return "soles";
    case FaultDevice::left_arm:
      return "left_arm";
    case FaultDevice::right_arm:
      return "right_arm";
    case FaultDevice::left_leg:
      return "left_leg";
    case FaultDevice::right_leg:
      return "right_leg";
    case FaultDevice::referee:
      return "referee";
    case FaultDevice::gripper:
      return "gripper";
  }
  return "unknown";
}

std::string_view to_string(FaultKind kind) {
  switch (kind) {
    case FaultKind::off:
      return "off";
    case FaultKind::stuck:
      return "stuck";
    case FaultKind::garbage:
      return "garbage";
    case FaultKind::wrong:
      return "wrong";
    case FaultKind::slow:
      return "slow";
    case FaultKind::delayed:
      return "delayed";
    case FaultKind::intermittent:
      return "intermittent";
    case FaultKind::duplicated:
      return "duplicated";
    case FaultKind::closed:
      return "closed";
  }
  return "unknown";
}

const char* why_not(FaultDevice device, FaultKind kind) {
  if (kind == FaultKind::closed) return device == FaultDevice::link ? nullptr : "only a connection closes; use off";
  if (is_actuator(device))
    return kind == FaultKind::duplicated ? "a command is a state: the same one twice acts like once" : nullptr;
  if (device == FaultDevice::referee)
    return kind == FaultKind::garbage || kind == FaultKind::wrong
               ? "a referee's word comes whole or not at all: its datagrams carry checksums"
               : nullptr;
  if (device != FaultDevice::link) return nullptr;
  switch (kind) {
    case FaultKind::off:
    case FaultKind::delayed:
    case FaultKind::intermittent:
      return nullptr;
    case FaultKind::slow:
      return "rates belong to devices; a connection that is too slow delays";
    case FaultKind::duplicated:
      return "a byte stream repeats nothing";
    default:
      return "a byte stream delivers what was sent; values go wrong in devices, bytes in the protocol's fuzzer";
  }
}

FaultLog::FaultLog(const std::vector<Fault>& faults, std::uint64_t seed) : seed_(seed) {
  for (const Fault& f : faults) entries_.push_back({f, 0});
}

DeviceFaults::DeviceFaults(FaultLog& log, FaultDevice device, std::optional<FaultDevice> bus)
    : random_(log.seed(), 0x666c7400u + static_cast<std::uint32_t>(device)) {
  for (std::size_t i = 0; i < log.entries().size(); ++i) {
    FaultLog::Entry& entry = log.entries()[i];
    const bool of_bus = bus == entry.fault.device && entry.fault.kind != FaultKind::wrong;
    if (entry.fault.device != device && entry.fault.device != FaultDevice::link && !of_bus) continue;
    if (entry.fault.kind == FaultKind::closed) continue;  // the connection itself plays it
    Running r;
    r.entry = &entry;
    r.random = math::Random(log.seed(), 0x62757200u + static_cast<std::uint32_t>(i));
    r.toggle_ns = entry.fault.from_ns;
    faults_.push_back(r);
  }
}

FaultEffect DeviceFaults::next(hal::Time stamp) {
  FaultEffect effect;
  for (Running& r : faults_)
    if (r.entry->fault.acts_at(stamp)) apply(r, stamp, effect);
  return effect;
}

bool DeviceFaults::silent(Running& r, hal::Time t) {
  while (t.ns >= r.toggle_ns) {
    r.silent = !r.silent;
    // Uniform from 0 to twice the mean; at least a microsecond, so that this loop ends.
    const double length_ns = 2e9 * r.entry->fault.amount * r.random.uniform();
    r.toggle_ns += std::max<std::int64_t>(static_cast<std::int64_t>(length_ns), 1000);
  }
  return r.silent;
}

void DeviceFaults::apply(Running& r, hal::Time t, FaultEffect& effect) {
  const Fault& f = r.entry->fault;
  bool struck = true;
  switch (f.kind) {
    case FaultKind::off:
      effect.lost = true;
      break;
    case FaultKind::stuck:
      effect.stuck = true;
      break;
    case FaultKind::garbage:
      effect.garbage = true;
      break;
    case FaultKind::wrong:
      effect.wrong = effect.wrong.value_or(0) + f.amount;
      break;
    case FaultKind::slow:
      struck = r.seen++ % static_cast<std::uint64_t>(f.amount) != 0;
      effect.lost |= struck;
      break;
    case FaultKind::delayed:
      effect.delay += hal::Duration(static_cast<std::int64_t>(f.amount * 1e9));
      break;
    case FaultKind::intermittent:
      struck = silent(r, t);
      effect.lost |= struck;
      break;
    case FaultKind::duplicated:
      effect.duplicated = true;
      break;
    case FaultKind::closed:
      struck = false;
      break;
  }
  if (struck) r.entry->strike(t);
}

}  // namespace sinew::plant
