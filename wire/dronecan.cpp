#include "wire/dronecan.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "wire/can_check.hpp"
#include "wire/crc_ccitt.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint8_t kStart = 0x80, kEnd = 0x40, kToggle = 0x20, kTransferMask = 0x1F;
constexpr std::size_t kFrameData = 7;
constexpr auto kTimeout = std::chrono::seconds(2);  // specification: TRANSFER_TIMEOUT of CAN bus transport

}  // namespace

std::uint32_t dronecan_can_id(const DronecanId& id) noexcept {
  const std::uint32_t common = (id.priority & 0x1Fu) << 24 | (id.source & 0x7Fu);
  if (id.service)
    return common | (id.type & 0xFFu) << 16 | (id.request ? 0x8000u : 0u) | (id.destination & 0x7Fu) << 8 | 0x80u;
  if (id.source == 0) return common | (id.discriminator & 0x3FFFu) << 10 | (id.type & 3u) << 8;
  return common | static_cast<std::uint32_t>(id.type) << 8;
}

bool dronecan_parse_id(std::uint32_t can_id, DronecanId& out) noexcept {
  DronecanId id;
  id.priority = static_cast<std::uint8_t>(can_id >> 24 & 0x1F);
  id.service = (can_id & 0x80) != 0;
  id.source = static_cast<std::uint8_t>(can_id & 0x7F);
  if (id.service) {
    id.type = static_cast<std::uint16_t>(can_id >> 16 & 0xFF);
    id.request = (can_id & 0x8000) != 0;
    id.destination = static_cast<std::uint8_t>(can_id >> 8 & 0x7F);
    if (id.source == 0 || id.destination == 0) return false;
  } else if (id.source == 0) {
    id.type = static_cast<std::uint16_t>(can_id >> 8 & 3);
    id.discriminator = static_cast<std::uint16_t>(can_id >> 10 & 0x3FFF);
  } else {
    id.type = static_cast<std::uint16_t>(can_id >> 8);
  }
  out = id;
  return true;
}

std::uint16_t dronecan_crc_seed(std::uint64_t signature) noexcept {
  std::array<std::uint8_t, 8> bytes{};
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(signature >> (8 * i));
  return crc_ccitt(bytes);
}

DronecanSplitter::DronecanSplitter(const DronecanId& id, std::uint64_t signature, std::uint8_t transfer_id,
                                   std::span<const std::uint8_t> payload) noexcept
    : can_id_(dronecan_can_id(id)),
      transfer_id_(transfer_id & kTransferMask),
      rest_(payload),
      crc_(0),
      multi_(payload.size() > kFrameData) {
  if (multi_) crc_ = crc_ccitt(payload, dronecan_crc_seed(signature));
  done_ = multi_ && !id.service && id.source == 0;
}

bool DronecanSplitter::next(msg::CanFrame& out) noexcept {
  if (done_) return false;
  out = {};
  out.id = can_id_;
  out.flags = msg::kCanExtended;
  std::size_t used = 0;
  if (multi_ && first_) {
    out.data[used++] = static_cast<std::uint8_t>(crc_);
    out.data[used++] = static_cast<std::uint8_t>(crc_ >> 8);
  }
  const std::size_t n = std::min(rest_.size(), kFrameData - used);
  std::copy_n(rest_.begin(), n, out.data.begin() + static_cast<std::ptrdiff_t>(used));
  rest_ = rest_.subspan(n);
  used += n;
  done_ = rest_.empty();
  out.data[used++] =
      static_cast<std::uint8_t>((first_ ? kStart : 0) | (done_ ? kEnd : 0) | (toggle_ ? kToggle : 0) | transfer_id_);
  out.size = static_cast<std::uint32_t>(used);
  first_ = false;
  toggle_ = !toggle_;
  return true;
}

DronecanAssembler::DronecanAssembler(std::span<const DronecanWanted> wanted, std::size_t places)
    : wanted_(wanted.begin(), wanted.end()), places_(places) {}

const DronecanWanted* DronecanAssembler::wanted(const DronecanId& id) const noexcept {
  for (const DronecanWanted& w : wanted_)
    if (w.service == id.service && w.type == id.type) return &w;
  return nullptr;
}

DronecanAssembler::Place* DronecanAssembler::find(std::uint32_t can_id) noexcept {
  for (Place& p : places_)
    if (p.busy && p.can_id == can_id) return &p;
  return nullptr;
}

DronecanAssembler::Place* DronecanAssembler::free_place(Time now) noexcept {
  for (Place& p : places_) {
    if (p.busy && now - p.begun > kTimeout) {
      p.busy = false;
      ++stats_.timed_out;
    }
    if (!p.busy) return &p;
  }
  return nullptr;
}

DronecanAssembler::Heard DronecanAssembler::push(const msg::CanFrame& frame, Time now, std::uint8_t own_node,
                                                 DronecanTransfer& out) noexcept {
  DronecanId id;
  if (!is_can_frame(frame) || frame.fd() || frame.remote() || !frame.extended() || !dronecan_parse_id(frame.id, id))
    return Heard::foreign;
  const DronecanWanted* type = wanted(id);
  if (type == nullptr || (id.service && id.destination != own_node)) return Heard::foreign;
  if (frame.size == 0) {
    ++stats_.malformed;
    return Heard::broken;
  }
  const std::uint8_t tail = frame.data[frame.size - 1];
  if ((tail & kStart) == 0) return go_on(frame, id, now, out);
  if (Place* before = find(frame.id)) {
    before->busy = false;  // its sender has begun another one
    ++stats_.stray;
  }
  if ((tail & kToggle) != 0) {
    ++stats_.malformed;
    return Heard::broken;
  }
  if ((tail & kEnd) == 0) {
    if (id.source == 0) {
      ++stats_.malformed;
      return Heard::broken;
    }
    return begin(frame, type->signature, now);
  }
  ++stats_.transfers;
  out.id = id;
  out.transfer_id = tail & kTransferMask;
  out.stamp = frame.stamp;
  out.payload = frame.bytes().first(frame.size - 1);
  return Heard::complete;
}

DronecanAssembler::Heard DronecanAssembler::begin(const msg::CanFrame& frame, std::uint64_t signature,
                                                  Time now) noexcept {
  if (frame.size != 8) {
    ++stats_.malformed;
    return Heard::broken;
  }
  Place* place = free_place(now);
  if (place == nullptr) {
    ++stats_.no_room;
    return Heard::broken;
  }
  place->busy = true;
  place->can_id = frame.id;
  place->begun = now;
  place->stamp = frame.stamp;
  place->transfer_id = frame.data[7] & kTransferMask;
  place->toggle = true;
  place->said_crc = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8);
  place->signature = signature;
  place->size = kFrameData - 2;
  std::copy_n(frame.data.begin() + 2, place->size, place->data);
  return Heard::partial;
}

DronecanAssembler::Heard DronecanAssembler::go_on(const msg::CanFrame& frame, const DronecanId& id, Time now,
                                                  DronecanTransfer& out) noexcept {
  const std::uint8_t tail = frame.data[frame.size - 1];
  Place* place = find(frame.id);
  if (place != nullptr && now - place->begun > kTimeout) {
    place->busy = false;
    ++stats_.timed_out;
    place = nullptr;
  }
  // A frame that came twice has the same toggle as the last one: it is left out, and the transfer goes on.
  if (place == nullptr || place->transfer_id != (tail & kTransferMask) || place->toggle != ((tail & kToggle) != 0)) {
    ++stats_.stray;
    return Heard::broken;
  }
  const std::size_t n = frame.size - 1;
  const bool last = (tail & kEnd) != 0;
  if (place->size + n > kDronecanMaxPayload || (!last && n != kFrameData) || n == 0) {
    place->busy = false;
    ++stats_.malformed;
    return Heard::broken;
  }
  std::copy_n(frame.data.begin(), n, place->data + place->size);
  place->size += n;
  place->toggle = !place->toggle;
  if (!last) return Heard::partial;
  place->busy = false;  // its bytes stay until the next push()
  const std::span<const std::uint8_t> payload(place->data, place->size);
  if (crc_ccitt(payload, dronecan_crc_seed(place->signature)) != place->said_crc) {
    ++stats_.crc_errors;
    return Heard::broken;
  }
  ++stats_.transfers;
  out.id = id;
  out.transfer_id = place->transfer_id;
  out.stamp = place->stamp;
  out.payload = payload;
  return Heard::complete;
}

}  // namespace sinew::wire
