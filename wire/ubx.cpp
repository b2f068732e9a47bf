#include "wire/ubx.hpp"

#include <algorithm>
#include <cmath>

#include "wire/sensor_bytes.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint8_t kSync1 = 0xB5, kSync2 = 0x62, kNav = 0x01, kPvt = 0x07, kCfg = 0x06;
constexpr std::size_t kPvtBytes = 92, kPvtShortest = 84;  // protocol version 14 had 84

struct Checksum {
  std::uint8_t a = 0, b = 0;
  explicit Checksum(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      a = static_cast<std::uint8_t>(a + byte);
      b = static_cast<std::uint8_t>(b + a);
    }
  }
};

msg::GnssFix fix_of(std::uint8_t type, std::uint8_t flags) {
  using enum msg::GnssFix;
  if (type == 5) return time;
  if (!(flags & 0x01) || type < 2 || type > 4) return none;  // 1: dead reckoning only
  if (flags >> 6 == 2) return rtk_fixed;
  if (flags >> 6 == 1) return rtk_float;
  return type == 2 ? flat : full;
}

void put32(std::uint8_t* p, double value) {
  const auto v = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(value)));
  for (int i = 0; i < 4; ++i) p[i] = static_cast<std::uint8_t>(v >> (8 * i));
}

}  // namespace

FrameVerdict UbxFormat::check(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != kSync1 || (bytes.size() > 1 && bytes[1] != kSync2)) return {FrameVerdict::foreign};
  if (bytes.size() < 6) return {FrameVerdict::more};
  const std::size_t size = le16(&bytes[4]) + kUbxOverhead;
  if (size > kMaxFrame) return {FrameVerdict::broken};
  if (bytes.size() < size) return {FrameVerdict::more};
  const Checksum sum(bytes.subspan(2, size - 4));
  const bool right = bytes[size - 2] == sum.a && bytes[size - 1] == sum.b;
  return {right ? FrameVerdict::good : FrameVerdict::broken, size};
}

std::optional<UbxPvt> decode_nav_pvt(std::span<const std::uint8_t> frame) noexcept {
  if (frame.size() < kUbxOverhead + kPvtShortest || ubx_class(frame) != kNav || ubx_id(frame) != kPvt) return {};
  const std::uint8_t* p = ubx_payload(frame).data();
  UbxPvt out{.time_of_week_ms = le32(p),
             .year = le16(p + 4),
             .month = p[6],
             .day = p[7],
             .hour = p[8],
             .minute = p[9],
             .second = p[10],
             .date_valid = (p[11] & 1) != 0,
             .time_valid = (p[11] & 2) != 0,
             .sample = {}};
  msg::GnssSample& s = out.sample;
  s.fix = fix_of(p[20], p[21]);
  s.satellites = p[23];
  s.longitude_deg = le32s(p + 24) * 1e-7;
  s.latitude_deg = le32s(p + 28) * 1e-7;
  s.altitude_m = le32s(p + 36) * 1e-3;
  s.horizontal_accuracy_m = le32(p + 40) * 1e-3;
  s.vertical_accuracy_m = le32(p + 44) * 1e-3;
  s.velocity_mps = {le32s(p + 52) * 1e-3, le32s(p + 48) * 1e-3, le32s(p + 56) * -1e-3};  // north east down there
  s.speed_accuracy_mps = le32(p + 68) * 1e-3;
  return out;
}

std::size_t encode_ubx(std::uint8_t message_class, std::uint8_t id, std::span<const std::uint8_t> payload,
                       std::span<std::uint8_t> out) noexcept {
  const std::size_t size = payload.size() + kUbxOverhead;
  if (out.size() < size || payload.size() > 0xFFFF) return 0;
  const std::uint8_t head[] = {kSync1,
                               kSync2,
                               message_class,
                               id,
                               static_cast<std::uint8_t>(payload.size()),
                               static_cast<std::uint8_t>(payload.size() >> 8)};
  std::copy(std::begin(head), std::end(head), out.begin());
  std::copy(payload.begin(), payload.end(), out.begin() + 6);
  const Checksum sum(out.subspan(2, size - 4));
  out[size - 2] = sum.a;
  out[size - 1] = sum.b;
  return size;
}

std::size_t encode_enable_nav_pvt(std::span<std::uint8_t> out) noexcept {
  const std::uint8_t payload[] = {kNav, kPvt, 1};
  return encode_ubx(kCfg, 0x01, payload, out);
}

std::size_t encode_solution_rate(std::uint16_t period_ms, std::span<std::uint8_t> out) noexcept {
  const std::uint8_t payload[] = {static_cast<std::uint8_t>(period_ms),
                                  static_cast<std::uint8_t>(period_ms >> 8),
                                  1,
                                  0,
                                  1,
                                  0};  // each measurement a solution; in GPS time
  return encode_ubx(kCfg, 0x08, payload, out);
}

std::size_t encode_nav_pvt(const UbxPvt& pvt, std::span<std::uint8_t> out) noexcept {
  std::array<std::uint8_t, kPvtBytes> p{};
  const msg::GnssSample& s = pvt.sample;
  put32(&p[0], static_cast<std::int32_t>(pvt.time_of_week_ms));
  p[4] = static_cast<std::uint8_t>(pvt.year), p[5] = static_cast<std::uint8_t>(pvt.year >> 8);
  p[6] = static_cast<std::uint8_t>(pvt.month), p[7] = static_cast<std::uint8_t>(pvt.day);
  p[8] = static_cast<std::uint8_t>(pvt.hour), p[9] = static_cast<std::uint8_t>(pvt.minute);
  p[10] = static_cast<std::uint8_t>(pvt.second);
  p[11] = static_cast<std::uint8_t>((pvt.date_valid ? 1 : 0) | (pvt.time_valid ? 2 : 0));
  using enum msg::GnssFix;
  const bool good = s.fix != none && s.fix != time;
  if (good) p[20] = s.fix == flat ? 2 : 3, p[21] = 1;
  if (s.fix == time) p[20] = 5;
  if (s.fix == rtk_float) p[21] |= 0x40;
  if (s.fix == rtk_fixed) p[21] |= 0x80;
  p[23] = static_cast<std::uint8_t>(s.satellites);
  put32(&p[24], s.longitude_deg * 1e7), put32(&p[28], s.latitude_deg * 1e7), put32(&p[36], s.altitude_m * 1e3);
  put32(&p[40], s.horizontal_accuracy_m * 1e3), put32(&p[44], s.vertical_accuracy_m * 1e3);
  put32(&p[48], s.velocity_mps.y * 1e3), put32(&p[52], s.velocity_mps.x * 1e3), put32(&p[56], s.velocity_mps.z * -1e3);
  put32(&p[68], s.speed_accuracy_mps * 1e3);
  return encode_ubx(kNav, kPvt, p, out);
}

}  // namespace sinew::wire
