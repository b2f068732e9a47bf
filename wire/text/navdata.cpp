#include "wire/text/navdata.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace sinew::wire {
namespace {

constexpr std::uint32_t kHeader1 = 0x55667788, kHeader2 = 0x55667789;
constexpr std::size_t kHeaderBytes = 16, kOptionHead = 4;
constexpr std::uint16_t kDemo = 0, kRaw = 2, kChecksum = 0xffff;
constexpr std::size_t kDemoBytes = 36;                // as far as they are read: up to the velocity
constexpr std::size_t kDemoSent = 144;                // with the detection matrices behind
constexpr std::size_t kRawBytes = 20, kRawSent = 48;  // up to the voltage; the whole of it

std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t i) {
  return bytes[i] | std::uint32_t{bytes[i + 1]} << 8 | std::uint32_t{bytes[i + 2]} << 16 |
         std::uint32_t{bytes[i + 3]} << 24;
}
std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t i) {
  return static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8);
}
/// Thousandths as an integer: the nearest that the type has; 0 for NaN.
template <class Integer>
std::uint32_t thousandths(float value) {
  constexpr double kLeast = std::numeric_limits<Integer>::min(), kMost = std::numeric_limits<Integer>::max();
  const double whole = std::floor(static_cast<double>(value) * 1000 + 0.5);
  if (std::isnan(whole)) return 0;
  return static_cast<std::uint32_t>(static_cast<Integer>(std::clamp(whole, kLeast, kMost)));
}
float f32_at(std::span<const std::uint8_t> bytes, std::size_t i) { return std::bit_cast<float>(u32_at(bytes, i)); }

std::uint32_t navdata_sum(std::span<const std::uint8_t> bytes) {
  std::uint32_t sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return sum;
}

void read_demo(std::span<const std::uint8_t> body, Navdata& out) {
  out.has_demo = true;
  out.fly_state = u16_at(body, 0);
  out.control_state = u16_at(body, 2);
  out.battery_percent = u32_at(body, 4);
  out.pitch_deg = f32_at(body, 8) / 1000;
  out.roll_deg = f32_at(body, 12) / 1000;
  out.yaw_deg = f32_at(body, 16) / 1000;
  out.altitude_m = static_cast<float>(std::bit_cast<std::int32_t>(u32_at(body, 20))) / 1000;
  out.vx_mps = f32_at(body, 24) / 1000;
  out.vy_mps = f32_at(body, 28) / 1000;
  out.vz_mps = f32_at(body, 32) / 1000;
}

class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> out) : out_(out) {}
  void u16(std::uint32_t value) { bytes(value, 2); }
  void u32(std::uint32_t value) { bytes(value, 4); }
  void milli(float value) { u32(std::bit_cast<std::uint32_t>(value * 1000)); }
  void zeros(std::size_t n) {
    for (; n > 0; --n) bytes(0, 1);
  }
  std::size_t used() const { return used_; }
  bool fits() const { return used_ <= out_.size(); }

 private:
  void bytes(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i, ++used_)
      if (used_ < out_.size()) out_[used_] = static_cast<std::uint8_t>(value >> 8 * i);
  }
  std::span<std::uint8_t> out_;
  std::size_t used_ = 0;
};

struct Field {
  std::string_view message, key;
  std::size_t indices;
  double (*get)(const Navdata&, std::size_t);
};
constexpr Field kFields[] = {
    {"state", "bits", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.state); }},
    {"state", "sequence", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.sequence); }},
    {"demo", "fly_state", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.fly_state); }},
    {"demo", "control_state", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.control_state); }},
    {"demo", "battery", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.battery_percent); }},
    {"demo", "pitch", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.pitch_deg); }},
    {"demo", "roll", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.roll_deg); }},
    {"demo", "yaw", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.yaw_deg); }},
    {"demo", "altitude", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.altitude_m); }},
    {"demo", "velocity", 3,
     [](const Navdata& d, std::size_t i) {
       return static_cast<double>(i == 0 ? d.vx_mps : i == 1 ? d.vy_mps : d.vz_mps);
     }},
    {"raw", "voltage", 1, [](const Navdata& d, std::size_t) { return static_cast<double>(d.battery_v); }},
};

const Field* field_of(std::string_view message, std::string_view key, std::size_t index) {
  for (const Field& f : kFields)
    if (f.message == message && f.key == key) return index < f.indices ? &f : nullptr;
  return nullptr;
}

std::size_t state_bit(std::string_view key) {
  return static_cast<std::size_t>(std::find(kNavdataStates.begin(), kNavdataStates.end(), key) -
                                  kNavdataStates.begin());
}

}  // namespace

NavdataError decode_navdata(std::span<const std::uint8_t> datagram, Navdata& out) noexcept {
  out = {};
  if (datagram.size() < kHeaderBytes) return NavdataError::size;
  const std::uint32_t header = u32_at(datagram, 0);
  if (header != kHeader1 && header != kHeader2) return NavdataError::header;
  out.state = u32_at(datagram, 4);
  out.sequence = u32_at(datagram, 8);
  out.vision = u32_at(datagram, 12);
  for (std::size_t at = kHeaderBytes; at + kOptionHead <= datagram.size();) {
    const std::uint16_t tag = u16_at(datagram, at);
    const std::size_t size = u16_at(datagram, at + 2);
    if (size < kOptionHead || size > datagram.size() - at) return NavdataError::size;
    const auto body = datagram.subspan(at + kOptionHead, size - kOptionHead);
    if (tag == kChecksum) {
      if (body.size() < 4) return NavdataError::size;
      return u32_at(body, 0) == navdata_sum(datagram.first(at)) ? NavdataError::none : NavdataError::checksum;
    }
    if (tag == kDemo) {
      if (body.size() < kDemoBytes) return NavdataError::size;
      read_demo(body, out);
    }
    if (tag == kRaw) {
      if (body.size() < kRawBytes) return NavdataError::size;
      out.has_raw = true;
      out.battery_v = static_cast<float>(u32_at(body, 16)) / 1000;
    }
    at += size;
  }
  return NavdataError::checksum;  // there is none
}

bool is_navdata_value(std::string_view message, std::string_view key, std::size_t index) noexcept {
  if (field_of(message, key, index)) return true;
  return message == "state" && index == 0 && state_bit(key) < kNavdataStates.size();
}

std::optional<double> navdata_value(const Navdata& data, std::string_view message, std::string_view key,
                                    std::size_t index) noexcept {
  if ((message == "demo" && !data.has_demo) || (message == "raw" && !data.has_raw)) return std::nullopt;
  if (const Field* f = field_of(message, key, index)) {
    const double value = f->get(data, index);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
  if (!is_navdata_value(message, key, index)) return std::nullopt;
  return (data.state >> state_bit(key) & 1) != 0 ? 1 : 0;
}

std::size_t encode_navdata(const Navdata& data, std::span<std::uint8_t> out) noexcept {
  ByteWriter w(out);
  w.u32(kHeader1), w.u32(data.state), w.u32(data.sequence), w.u32(data.vision);
  if (data.has_demo) {
    w.u16(kDemo), w.u16(kOptionHead + kDemoSent);
    w.u16(data.fly_state), w.u16(data.control_state), w.u32(data.battery_percent);
    w.milli(data.pitch_deg), w.milli(data.roll_deg), w.milli(data.yaw_deg);
    w.u32(thousandths<std::int32_t>(data.altitude_m));
    w.milli(data.vx_mps), w.milli(data.vy_mps), w.milli(data.vz_mps);
    w.zeros(kDemoSent - kDemoBytes);
  }
  if (data.has_raw) {
    w.u16(kRaw), w.u16(kOptionHead + kRawSent);
    w.zeros(16);
    w.u32(thousandths<std::uint32_t>(data.battery_v));
    w.zeros(kRawSent - kRawBytes);
  }
  if (!w.fits()) return 0;
  const std::uint32_t sum = navdata_sum(out.first(w.used()));
  w.u16(kChecksum), w.u16(8), w.u32(sum);
  return w.fits() ? w.used() : 0;
}

}  // namespace sinew::wire
