#include "wire/servos/dynamixel.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

constexpr std::size_t kHead1 = 4, kHead2 = 7;  // up to and with the length
constexpr std::uint8_t kStuff = 0xFD;

constexpr std::array<std::uint16_t, 256> kDxlCrcTable = [] {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000u) != 0 ? (crc << 1) ^ 0x8005u : crc << 1;
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

bool is_header2(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 4> kHeader{0xFF, 0xFF, 0xFD, 0x00};
  const std::size_t n = std::min(bytes.size(), kHeader.size());
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n), kHeader.begin());
}

bool ends_like_header(std::span<const std::uint8_t> bytes) {
  const std::size_t n = bytes.size();
  return n >= 3 && bytes[n - 3] == 0xFF && bytes[n - 2] == 0xFF && bytes[n - 1] == 0xFD;
}

}  // namespace

std::string_view to_string(DxlInstruction instruction) {
  switch (instruction) {
    case DxlInstruction::ping:
      return "ping";
    case DxlInstruction::read:
      return "read";
    case DxlInstruction::write:
      return "write";
    case DxlInstruction::reg_write:
      return "reg write";
    case DxlInstruction::action:
      return "action";
    case DxlInstruction::factory_reset:
      return "factory reset";
    case DxlInstruction::reboot:
      return "reboot";
    case DxlInstruction::clear:
      return "clear";
    case DxlInstruction::status:
      return "status";
    case DxlInstruction::sync_read:
      return "sync read";
    case DxlInstruction::sync_write:
      return "sync write";
    case DxlInstruction::fast_sync_read:
      return "fast sync read";
    case DxlInstruction::bulk_read:
      return "bulk read";
    case DxlInstruction::bulk_write:
      return "bulk write";
    case DxlInstruction::fast_bulk_read:
      return "fast bulk read";
  }
  return "unknown";
}

std::string_view to_string(DxlError error) {
  constexpr std::array<std::string_view, 8> kNames{"none",       "result fail", "instruction", "crc",
                                                   "data range", "data length", "data limit",  "access"};
  const auto at = static_cast<std::size_t>(error);
  return at < kNames.size() ? kNames[at] : "unknown";
}

std::uint16_t dxl_crc(std::span<const std::uint8_t> bytes, std::uint16_t crc) noexcept {
  for (const std::uint8_t b : bytes)
    crc = static_cast<std::uint16_t>((crc << 8) ^ kDxlCrcTable[(crc >> 8 ^ b) & 0xFFu]);
  return crc;
}

std::uint8_t dxl_checksum(std::span<const std::uint8_t> bytes) noexcept {
  unsigned sum = 0;
  for (const std::uint8_t b : bytes) sum += b;
  return static_cast<std::uint8_t>(~sum);
}

FrameVerdict Dxl1Format::check(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != 0xFF || (bytes.size() > 1 && bytes[1] != 0xFF)) return {FrameVerdict::foreign};
  if (bytes.size() > 2 && bytes[2] == 0xFF) return {FrameVerdict::foreign};  // no id: the header begins one byte later
  if (bytes.size() < kHead1) return {FrameVerdict::more};
  const std::size_t size = kHead1 + bytes[3];
  if (bytes[3] < 2) return {FrameVerdict::foreign};
  if (bytes.size() < size) return {FrameVerdict::more};
  const bool good = dxl_checksum(bytes.subspan(2, size - 3)) == bytes[size - 1];
  return {good ? FrameVerdict::good : FrameVerdict::broken, size};
}

FrameVerdict Dxl2Format::check(std::span<const std::uint8_t> bytes) noexcept {
  if (!is_header2(bytes)) return {FrameVerdict::foreign};
  if (bytes.size() < kHead2) return {FrameVerdict::more};
  const std::size_t length = static_cast<std::size_t>(bytes[5]) | static_cast<std::size_t>(bytes[6]) << 8;
  const std::size_t size = kHead2 + length;
  if (bytes[4] == 0xFF || bytes[4] == 0xFD || length < 3 || size > kMaxFrame) return {FrameVerdict::foreign};
  if (bytes.size() < size) return {FrameVerdict::more};
  const std::uint16_t crc = dxl_crc(bytes.first(size - 2));
  const bool good = bytes[size - 2] == (crc & 0xFF) && bytes[size - 1] == crc >> 8;
  return {good ? FrameVerdict::good : FrameVerdict::broken, size};
}

DxlPacket DxlReader::take_apart(std::span<const std::uint8_t> frame) noexcept {
  if (version_ == DxlVersion::one) return {frame[2], frame[4], frame[4], frame.subspan(5, frame.size() - 6)};
  DxlPacket packet{frame[4], frame[7], 0, {}};
  std::span<const std::uint8_t> inside = frame.subspan(kHead2, frame.size() - kHead2 - 2);
  const bool status = packet.is(DxlInstruction::status);
  if (!(status && packet.id == kDxlBroadcast)) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < inside.size(); ++i) {
      plain_[n++] = inside[i];
      if (ends_like_header(inside.first(i + 1)) && i + 1 < inside.size() && inside[i + 1] == kStuff) ++i;
    }
    inside = {plain_.data(), n};
  }
  if (status && inside.size() > 1) packet.error = inside[1];
  packet.parameters = inside.subspan(std::min<std::size_t>(status ? 2 : 1, inside.size()));
  return packet;
}

DxlFastParts::DxlFastParts(const DxlPacket& packet) noexcept : error_(packet.error) {
  if (packet.is(DxlInstruction::status) && packet.id == kDxlBroadcast) rest_ = packet.parameters;
}

bool DxlFastParts::next(std::size_t size, DxlFastPart& out) noexcept {
  if (rest_.size() < 1 + size) return false;
  out = {rest_[0], error_, rest_.subspan(1, size)};
  rest_ = rest_.subspan(1 + size);
  // Between two parts: the CRC of this one, and the next one's error.
  error_ = rest_.size() > 2 ? rest_[2] : std::uint8_t{0};
  rest_ = rest_.subspan(rest_.size() < 3 ? rest_.size() : 3);
  return true;
}

// ---- building ----

DxlBuilder::DxlBuilder(DxlVersion version, std::uint8_t id, std::uint8_t code) noexcept : version_(version) {
  if (version == DxlVersion::one)
    for (const std::uint8_t b : {std::uint8_t{0xFF}, std::uint8_t{0xFF}, id, std::uint8_t{0}}) buffer_[size_++] = b;
  else
    for (const std::uint8_t b : {std::uint8_t{0xFF}, std::uint8_t{0xFF}, std::uint8_t{0xFD}, std::uint8_t{0}, id,
                                 std::uint8_t{0}, std::uint8_t{0}})
      buffer_[size_++] = b;
  put(code);
}

DxlBuilder DxlBuilder::status(DxlVersion version, std::uint8_t id, std::uint8_t error) noexcept {
  if (version == DxlVersion::one) return {version, id, error};
  DxlBuilder packet(version, id, DxlInstruction::status);
  packet.put(error);
  return packet;
}

bool DxlBuilder::fits(std::size_t parameters) const noexcept {
  const std::size_t most = version_ == DxlVersion::one ? Dxl1Format::kMaxFrame - 1 : Dxl2Format::kMaxFrame - 2;
  return size_ + parameters <= most;
}

void DxlBuilder::put(std::uint8_t value) noexcept {
  if (!fits(1)) {
    overflow_ = true;
    return;
  }
  buffer_[size_++] = value;
  if (version_ == DxlVersion::one || !ends_like_header({buffer_.data() + kHead2, size_ - kHead2})) return;
  if (!fits(1))
    overflow_ = true;
  else
    buffer_[size_++] = kStuff;
}

DxlBuilder& DxlBuilder::byte(std::uint8_t value) noexcept {
  put(value);
  return *this;
}
DxlBuilder& DxlBuilder::word(std::uint16_t value) noexcept {
  put(static_cast<std::uint8_t>(value));
  put(static_cast<std::uint8_t>(value >> 8));
  return *this;
}
DxlBuilder& DxlBuilder::bytes(std::span<const std::uint8_t> values) noexcept {
  for (const std::uint8_t value : values) put(value);
  return *this;
}
DxlBuilder& DxlBuilder::place(std::uint16_t value) noexcept {
  if (version_ == DxlVersion::two) return word(value);
  if (value > 0xFF) overflow_ = true;
  return byte(static_cast<std::uint8_t>(value));
}

std::span<const std::uint8_t> DxlBuilder::finish() noexcept {
  if (overflow_) return {};
  std::size_t n = size_;
  if (version_ == DxlVersion::one) {
    buffer_[3] = static_cast<std::uint8_t>(n - kHead1 + 1);
    buffer_[n] = dxl_checksum({buffer_.data() + 2, n - 2});
    return {buffer_.data(), n + 1};
  }
  const std::size_t length = n - kHead2 + 2;
  buffer_[5] = static_cast<std::uint8_t>(length);
  buffer_[6] = static_cast<std::uint8_t>(length >> 8);
  const std::uint16_t crc = dxl_crc({buffer_.data(), n});
  buffer_[n++] = static_cast<std::uint8_t>(crc);
  buffer_[n++] = static_cast<std::uint8_t>(crc >> 8);
  return {buffer_.data(), n};
}

DxlBuilder dxl_ping(DxlVersion v, std::uint8_t id) noexcept { return {v, id, DxlInstruction::ping}; }

DxlBuilder dxl_read(DxlVersion v, std::uint8_t id, std::uint16_t address, std::uint16_t size) noexcept {
  DxlBuilder packet(v, id, DxlInstruction::read);
  return packet.place(address).place(size);
}

DxlBuilder dxl_write(DxlVersion v, std::uint8_t id, std::uint16_t address,
                     std::span<const std::uint8_t> data) noexcept {
  DxlBuilder packet(v, id, DxlInstruction::write);
  return packet.place(address).bytes(data);
}

DxlBuilder dxl_reg_write(DxlVersion v, std::uint8_t id, std::uint16_t address,
                         std::span<const std::uint8_t> data) noexcept {
  DxlBuilder packet(v, id, DxlInstruction::reg_write);
  return packet.place(address).bytes(data);
}

DxlBuilder dxl_action(DxlVersion v, std::uint8_t id) noexcept { return {v, id, DxlInstruction::action}; }

DxlBuilder dxl_factory_reset(DxlVersion v, std::uint8_t id, DxlKeep keep) noexcept {
  DxlBuilder packet(v, id, DxlInstruction::factory_reset);
  if (v == DxlVersion::two) packet.byte(static_cast<std::uint8_t>(keep));
  return packet;
}

DxlBuilder dxl_reboot(DxlVersion v, std::uint8_t id) noexcept { return {v, id, DxlInstruction::reboot}; }

DxlBuilder dxl_clear_turns(std::uint8_t id) noexcept {
  constexpr std::array<std::uint8_t, 5> kTurns{0x01, 0x44, 0x58, 0x4C, 0x22};
  DxlBuilder packet(DxlVersion::two, id, DxlInstruction::clear);
  return packet.bytes(kTurns);
}

DxlBuilder dxl_sync_read(DxlVersion v, std::uint16_t address, std::uint16_t size, std::span<const std::uint8_t> ids,
                         bool fast) noexcept {
  DxlBuilder packet(v, kDxlBroadcast, fast ? DxlInstruction::fast_sync_read : DxlInstruction::sync_read);
  return packet.place(address).place(size).bytes(ids);
}

DxlBuilder dxl_sync_write(DxlVersion v, std::uint16_t address, std::uint16_t size) noexcept {
  DxlBuilder packet(v, kDxlBroadcast, DxlInstruction::sync_write);
  return packet.place(address).place(size);
}

DxlBuilder dxl_bulk_read(DxlVersion v, std::span<const DxlPlace> places, bool fast) noexcept {
  DxlBuilder packet(v, kDxlBroadcast, fast ? DxlInstruction::fast_bulk_read : DxlInstruction::bulk_read);
  if (v == DxlVersion::one) packet.byte(0);
  for (const DxlPlace& p : places) {
    if (v == DxlVersion::one)
      packet.place(p.size).byte(p.id).place(p.address);
    else
      packet.byte(p.id).place(p.address).place(p.size);
  }
  return packet;
}

DxlBuilder dxl_bulk_write() noexcept { return {DxlVersion::two, kDxlBroadcast, DxlInstruction::bulk_write}; }

void dxl_bulk_part(DxlBuilder& packet, std::uint8_t id, std::uint16_t address,
                   std::span<const std::uint8_t> data) noexcept {
  packet.byte(id).place(address).place(static_cast<std::uint16_t>(data.size())).bytes(data);
}

}  // namespace sinew::wire
