#include "drivers/joints/can_scan.hpp"

#include <algorithm>
#include <cstdio>

#include "wire/cybergear.hpp"
#include "wire/dronecan_types.hpp"
#include "wire/mit_motor.hpp"

namespace sinew::drivers {
namespace {

using hal::Duration;
using hal::Time;
using namespace std::chrono_literals;

constexpr int kScanRounds = 2;
constexpr Duration kAnswer = 200ms;    // after the last question
constexpr Duration kMitAnswer = 50ms;  // a motor answers at once
constexpr Duration kBusPatience = 1s;  // a bus may be away for a moment
constexpr std::uint32_t kHost = 0xFD;  // of CyberGear's manual
constexpr std::size_t kPlaces = 4;     // NodeStatus is one frame: no transfer is ever under way

const wire::DronecanWanted kScanHeard[] = {wire::kDronecanNodeStatus};

}  // namespace

const char* to_string(CanFamily family) {
  switch (family) {
    case CanFamily::canopen:
      return "canopen";
    case CanFamily::mit:
      return "mit";
    case CanFamily::cybergear:
      return "cybergear";
    case CanFamily::dronecan:
      break;
  }
  return "dronecan";
}

std::string describe(const CanFound& f) {
  char text[160] = "";
  std::string all;
  const auto add = [&](const char* format, auto... values) {
    std::snprintf(text, sizeof text, format, values...);
    all += (all.empty() ? "" : ", ") + std::string(text);
  };
  if (f.device_type) {
    add("type 0x%08X", *f.device_type);
    if ((*f.device_type & 0xFFFF) == 402) all += " (CiA 402)";
  }
  if (f.vendor) add("vendor 0x%08X", *f.vendor);
  if (f.product) add("product 0x%08X", *f.product);
  if (f.family == CanFamily::mit) add("answers under 0x%03X", f.replies_as);
  if (f.family == CanFamily::cybergear) add("serial %016llX", static_cast<unsigned long long>(f.serial));
  if (f.family == CanFamily::dronecan) {
    constexpr const char* kHealth[] = {"ok", "warning", "error", "critical"};
    constexpr const char* kMode[] = {"operational", "initialising", "maintenance", "software update"};
    add("health %s", kHealth[f.health & 3]);
    if (f.mode < 4)
      add("%s", kMode[f.mode]);
    else
      add("mode %u", static_cast<unsigned>(f.mode));
  }
  return all;
}

msg::CanFrame CanScan::Question::frame() const {
  switch (family) {
    case CanFamily::canopen:
      return encode_sdo_request(id, wire::sdo_read(object));
    case CanFamily::mit:
      return wire::encode_mit(id, wire::MitSwitch::disable);
    default:
      return wire::encode_cybergear(wire::CyberGearKind::identify, kHost, id);
  }
}

CanScan::CanScan(hal::CanBus& bus, const Options& options)
    : bus_(bus), options_(options), assembler_(kScanHeard, kPlaces) {
  options_.most_id = std::clamp<std::uint32_t>(options_.most_id, 1, kIds - 1);
}

bool CanScan::wants(CanFamily family) const { return std::ranges::count(options_.families, family) > 0; }

CanFound* CanScan::find(CanFamily family, std::uint32_t id) {
  const auto it = std::ranges::find_if(found_, [&](const CanFound& f) { return f.family == family && f.id == id; });
  return it == found_.end() ? nullptr : &*it;
}

CanFound& CanScan::note(CanFamily family, std::uint32_t id) {
  if (CanFound* known = find(family, id)) return *known;
  found_.push_back({.family = family, .id = id});
  return found_.back();
}

/// All that have not answered yet, the first one at the back.
void CanScan::queue_round() {
  for (const CanFamily family : {CanFamily::cybergear, CanFamily::mit, CanFamily::canopen}) {
    if (!wants(family)) continue;
    for (std::uint32_t id = options_.most_id; id > 0; --id)
      if (!find(family, id)) queue_.push_back({family, id, wire::kDeviceType});
  }
  ++round_;
}

hal::Result<Time> CanScan::step(Time now) {
  if (!begun_) begun_ = true, begin_ = next_ = last_question_ = good_ = now;
  msg::CanFrame frame;
  for (int most = 0; most < 10000; ++most) {
    const auto got = bus_.read(frame);
    if (!got && now - good_ > kBusPatience) return got.error();
    if (!got || !*got) break;
    hear(frame, now);
  }
  if (queue_.empty() && round_ < kScanRounds && now - last_question_ >= (round_ > 0 ? kAnswer : Duration{0}))
    queue_round();
  while (!queue_.empty() && now >= next_) {
    const Question question = queue_.back();
    const msg::CanFrame ask = question.frame();
    if (const hal::Status sent = bus_.send(ask, now + 100ms); !sent) {
      if (now - good_ > kBusPatience) return sent.error();
      next_ = now + 5ms;  // full, or away: the same one again
      break;
    }
    queue_.pop_back();
    good_ = last_question_ = now;
    ++asked_;
    if (question.family == CanFamily::mit) mit_asked_[question.id] = now;
    const std::uint32_t rate = bus_.bit_rate();
    const Duration quarter = rate > 0 ? Duration{4'000'000'000 * hal::can_frame_bits(ask) / rate} : Duration{0};
    next_ = now + std::max<Duration>(1ms, quarter);
  }
  const Duration listens = wants(CanFamily::dronecan) ? kListen : kAnswer;
  done_ = now - begin_ >= kMost ||
          (queue_.empty() && round_ >= kScanRounds && now - last_question_ >= kAnswer && now - begin_ >= listens);
  return std::min(queue_.empty() ? now + 5ms : next_, now + 5ms);
}

void CanScan::hear(const msg::CanFrame& frame, Time now) {
  if (frame.error() || frame.remote()) return;
  good_ = now;
  if (frame.extended()) return hear_extended(frame, now);
  if (hear_mit(frame, now)) return;
  const wire::CanopenId id = wire::canopen_id(frame.id);
  if (id.kind == wire::CanopenKind::sdo_reply && wants(CanFamily::canopen)) hear_sdo(frame, id.node);
}

void CanScan::hear_sdo(const msg::CanFrame& frame, std::uint32_t node) {
  const auto reply = wire::decode_sdo_reply(frame);
  const bool ours = reply && (reply->object == wire::kDeviceType || reply->object == wire::kVendorId ||
                              reply->object == wire::kProductCode);
  if (!ours || node > options_.most_id) return;  // an answer to another master
  CanFound* known = find(CanFamily::canopen, node);
  if (!known) {
    queue_.push_back({CanFamily::canopen, node, wire::kProductCode});
    queue_.push_back({CanFamily::canopen, node, wire::kVendorId});
    known = &note(CanFamily::canopen, node);
  }
  if (reply->kind != wire::Sdo::Kind::value) return;  // a refusal: the device is there, and has no more to say of this
  (reply->object == wire::kDeviceType ? known->device_type
   : reply->object == wire::kVendorId ? known->vendor
                                      : known->product) = reply->value();
}

/// An answer names its motor in the first byte, or in the byte's lower half; if both fit, the motor asked last is
/// meant.
bool CanScan::hear_mit(const msg::CanFrame& frame, Time now) {
  const bool theirs =
      frame.id <= 0x7F || (frame.id >= 0x100 && frame.id < 0x180) || std::ranges::count(options_.masters, frame.id) > 0;
  if (!wants(CanFamily::mit) || !theirs || frame.size < 6 || frame.size > 8) return false;
  std::uint32_t best = 0;
  for (const std::uint32_t id : {std::uint32_t{frame.data[0]}, std::uint32_t{frame.data[0]} & 0xF}) {
    if (id == 0 || id > options_.most_id || mit_asked_[id].ns == 0 || now - mit_asked_[id] > kMitAnswer) continue;
    if (best == 0 || mit_asked_[id] > mit_asked_[best]) best = id;
  }
  if (best == 0) return false;
  note(CanFamily::mit, best).replies_as = frame.id;
  return true;
}

void CanScan::hear_extended(const msg::CanFrame& frame, Time now) {
  if (wants(CanFamily::cybergear)) {
    const wire::CyberGearId id = wire::split_cybergear_id(frame.id);
    const auto serial = wire::decode_cybergear_identity(frame);
    if (serial && id.target == wire::kCyberGearBroadcast && id.data >= 1 && id.data <= options_.most_id) {
      note(CanFamily::cybergear, id.data).serial = *serial;
      return;
    }
  }
  wire::DronecanTransfer transfer;
  wire::DronecanNodeStatus status;
  if (!wants(CanFamily::dronecan) ||
      assembler_.push(frame, now, 0, transfer) != wire::DronecanAssembler::Heard::complete || transfer.id.source == 0 ||
      !decode(transfer.payload, status))
    return;
  CanFound& node = note(CanFamily::dronecan, transfer.id.source);
  node.health = static_cast<std::uint8_t>(status.health), node.mode = status.mode;
}

std::vector<CanFound> CanScan::found() const {
  std::vector<CanFound> sorted = found_;
  std::ranges::sort(sorted, [](const CanFound& a, const CanFound& b) {
    return a.family != b.family ? a.family < b.family : a.id < b.id;
  });
  return sorted;
}

}  // namespace sinew::drivers
