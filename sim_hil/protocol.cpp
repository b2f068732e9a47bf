#include "sim_hil/protocol.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Status;

Error bad(const char* rule, std::int64_t value = 0) { return Error{Errc::bad_data, rule, value}; }

bool is_name_character(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

/// Little-endian output, the same on every machine.
class Put {
 public:
  explicit Put(std::byte* to) : to_(to), start_(to) {}
  template <class U>
  Put& integer(U value) {
    using Unsigned = std::make_unsigned_t<U>;
    const auto bits = static_cast<Unsigned>(value);
    for (std::size_t i = 0; i < sizeof(U); ++i) *to_++ = static_cast<std::byte>(bits >> (8 * i));
    return *this;
  }
  Put& u16(std::uint16_t v) { return integer(v); }
  Put& u32(std::uint32_t v) { return integer(v); }
  Put& u64(std::uint64_t v) { return integer(v); }
  Put& i64(std::int64_t v) { return integer(v); }
  Put& f32(double v) { return integer(std::bit_cast<std::uint32_t>(static_cast<float>(v))); }
  Put& f64(double v) { return integer(std::bit_cast<std::uint64_t>(v)); }
  Put& vec(const msg::Vec3& v) { return f64(v.x).f64(v.y).f64(v.z); }
  Put& name(std::string_view text) {
    if (text.empty()) text = "_";
    for (std::size_t i = 0; i < kNameBytes; ++i) {
      const bool inside = i < text.size() && i + 1 < kNameBytes;
      char c = '\0';
      if (inside) c = is_name_character(text[i]) ? text[i] : '_';
      *to_++ = static_cast<std::byte>(c);
    }
    return *this;
  }
  std::size_t written() const { return static_cast<std::size_t>(to_ - start_); }

 private:
  std::byte* to_;
  std::byte* start_;
};

/// Little-endian input; the caller has checked the size.
class Get {
 public:
  explicit Get(Bytes from) : from_(from.data()) {}
  template <class U>
  U integer() {
    std::make_unsigned_t<U> bits = 0;
    for (std::size_t i = 0; i < sizeof(U); ++i)
      bits = static_cast<decltype(bits)>(bits |
                                         static_cast<decltype(bits)>(static_cast<decltype(bits)>(from_[i]) << (8 * i)));
    from_ += sizeof(U);
    return static_cast<U>(bits);
  }
  std::uint16_t u16() { return integer<std::uint16_t>(); }
  std::uint32_t u32() { return integer<std::uint32_t>(); }
  std::uint64_t u64() { return integer<std::uint64_t>(); }
  std::int64_t i64() { return integer<std::int64_t>(); }
  double f32() { return static_cast<double>(std::bit_cast<float>(u32())); }
  double f64() { return std::bit_cast<double>(u64()); }
  msg::Vec3 vec() {
    msg::Vec3 v;
    v.x = f64(), v.y = f64(), v.z = f64();
    return v;
  }
  /// False when the 32 bytes are not a name: empty, not terminated, or with a character that the page does not allow.
  bool name(std::string& out) {
    const char* text = reinterpret_cast<const char*>(from_);
    from_ += kNameBytes;
    const std::size_t n = static_cast<std::size_t>(std::find(text, text + kNameBytes, '\0') - text);
    out.assign(text, n);
    return is_name(out);
  }

 private:
  const std::byte* from_;
};

bool is_rate(double rate) { return rate >= 0.001 && rate <= 1000; }  // false for NaN
bool is_time(std::int64_t ns) { return ns >= 0 && ns <= kMaxTimeNs; }

Status expect_size(Bytes payload, std::size_t bytes) {
  if (payload.size() != bytes) return bad("message has the wrong size for its type", std::int64_t(payload.size()));
  return {};
}

Status decode_ready(const Header& h, Get& get, Time& ready) {
  ready.ns = get.i64();
  if (!is_time(ready.ns) || ready < h.time) return bad("sample is ready before it was measured", ready.ns);
  return {};
}

Status check_camera(const DeviceInfo& d, std::uint64_t shared_bytes) {
  if (d.width == 0 || d.width > msg::kMaxImageWidth || d.height == 0 || d.height > msg::kMaxImageHeight)
    return bad("camera is larger than 1280x960 or empty", d.width);
  if (msg::bytes_per_pixel(d.format) == 0) return bad("unknown pixel format", std::int64_t(d.format));
  if (d.format == msg::PixelFormat::yuyv && d.width % 2 != 0) return bad("yuyv needs an even width", d.width);
  if (d.slots == 0) return {};
  if (d.slots < 3 || d.slots > 1024) return bad("camera has too few or too many frame slots", d.slots);
  if (d.slot_bytes < kSlotHeaderBytes + d.frame_bytes() || d.slot_bytes % 4 != 0 || d.slots_offset % 4 != 0)
    return bad("frame slot is too small or not aligned", d.slot_bytes);
  const std::uint64_t room = std::uint64_t{d.slots} * d.slot_bytes;
  if (d.slots_offset > shared_bytes || room > shared_bytes - d.slots_offset)
    return bad("frame slots lie outside of the shared memory", std::int64_t(d.slots_offset));
  return {};
}

Status decode_device(Get& get, std::uint64_t shared_bytes, DeviceInfo& d) {
  d.kind = static_cast<DeviceKind>(get.u16());
  get.u16();
  d.channels = get.u32();
  d.period = Duration(get.i64());
  d.latency = Duration(get.i64());
  d.width = get.u32(), d.height = get.u32();
  d.format = static_cast<msg::PixelFormat>(get.u32());
  d.slots = get.u32(), d.slots_offset = get.u64(), d.slot_bytes = get.u32();
  get.u32();
  const bool named = get.name(d.name);
  get.u64();
  if (!named) return bad("device has no proper name");
  if (!is_time(d.period.count()) || !is_time(d.latency.count())) return bad("device has a bad period or latency");
  switch (d.kind) {
    case DeviceKind::camera:
      return check_camera(d, shared_bytes);
    case DeviceKind::actuators:
      if (d.channels == 0 || d.channels > msg::kMaxChannels) return bad("actuators need 1 to 8 channels", d.channels);
      return {};
    case DeviceKind::joints:
      if (d.channels == 0 || d.channels > msg::kMaxChannels) return bad("joints are 1 to 8", d.channels);
      return {};
    case DeviceKind::imu:
    case DeviceKind::range:
    case DeviceKind::baro:
    case DeviceKind::battery:
    case DeviceKind::radio:
    case DeviceKind::soles:
    case DeviceKind::referee:
      return {};
  }
  return bad("unknown kind of device", std::int64_t(d.kind));
}

/// Payload sizes that each type allows.
struct Sizes {
  std::size_t least, most;
};
Status sizes_of(Type type, Sizes& out) {
  switch (type) {
    case Type::hello:
      out = {8, kHelloBytes};
      return {};  // a Hello or Welcome of another version may be shorter
    case Type::welcome:
      out = {8, kWelcomeBytes + kMaxDevices * kDeviceBytes};
      return {};
    case Type::start:
    case Type::grant:
    case Type::done:
    case Type::stop:
    case Type::stopped:
      out = {0, 0};
      return {};
    case Type::clock:
      out = {kClockBytes, kClockBytes};
      return {};
    case Type::clock_ask:
      out = {kClockAskBytes, kClockAskBytes};
      return {};
    case Type::clock_answer:
      out = {kClockAnswerBytes, kClockAnswerBytes};
      return {};
    case Type::command:
      out = {kCommandBytes, kCommandBytes};
      return {};
    case Type::bye:
    case Type::report:
      out = {0, kMaxTextBytes};
      return {};
    case Type::imu:
      out = {kImuBytes, kImuBytes};
      return {};
    case Type::range:
      out = {kRangeBytes, kRangeBytes};
      return {};
    case Type::baro:
      out = {kBaroBytes, kBaroBytes};
      return {};
    case Type::battery:
      out = {kBatteryBytes, kBatteryBytes};
      return {};
    case Type::soles:
      out = {kSolesBytes, kSolesBytes};
      return {};
    case Type::referee:
      out = {kRefereeBytes, kRefereeBytes};
      return {};
    case Type::joints:
      out = {kJointsHeadBytes + kJointBytes, kJointsHeadBytes + msg::kMaxChannels * kJointBytes};
      return {};
    case Type::datagram:
      out = {kDatagramHeadBytes + 1, kDatagramHeadBytes + msg::kMaxDatagramBytes};
      return {};
    case Type::transmit:
      out = {1, msg::kMaxDatagramBytes};
      return {};
    case Type::frame:
      out = {kFrameBytes, kMaxMessageBytes - kHeaderBytes};
      return {};
    case Type::truth:
      out = {kTruthBytes, kTruthBytes};
      return {};
  }
  return bad("unknown message type", std::int64_t(type));
}

}  // namespace

bool is_name(std::string_view text) {
  return !text.empty() && text.size() < kNameBytes && std::ranges::all_of(text, is_name_character);
}

std::string_view to_string(Type type) {
  switch (type) {
    case Type::hello:
      return "Hello";
    case Type::welcome:
      return "Welcome";
    case Type::start:
      return "Start";
    case Type::clock:
      return "Clock";
    case Type::grant:
      return "Grant";
    case Type::done:
      return "Done";
    case Type::command:
      return "Command";
    case Type::stop:
      return "Stop";
    case Type::bye:
      return "Bye";
    case Type::imu:
      return "Imu";
    case Type::range:
      return "Range";
    case Type::baro:
      return "Baro";
    case Type::battery:
      return "Battery";
    case Type::soles:
      return "Soles";
    case Type::referee:
      return "Referee";
    case Type::joints:
      return "Joints";
    case Type::datagram:
      return "Datagram";
    case Type::transmit:
      return "Transmit";
    case Type::frame:
      return "Frame";
    case Type::truth:
      return "Truth";
    case Type::report:
      return "Report";
    case Type::stopped:
      return "Stopped";
    case Type::clock_ask:
      return "ClockAsk";
    case Type::clock_answer:
      return "ClockAnswer";
  }
  return "unknown";
}

std::string_view to_string(DeviceKind kind) {
  switch (kind) {
    case DeviceKind::imu:
      return "imu";
    case DeviceKind::range:
      return "range";
    case DeviceKind::baro:
      return "baro";
    case DeviceKind::battery:
      return "battery";
    case DeviceKind::camera:
      return "camera";
    case DeviceKind::actuators:
      return "actuators";
    case DeviceKind::joints:
      return "joints";
    case DeviceKind::radio:
      return "radio";
    case DeviceKind::soles:
      return "soles";
    case DeviceKind::referee:
      return "referee";
  }
  return "unknown";
}

std::size_t encode(const Header& h, std::byte* out) noexcept {
  Put put(out);
  put.u32(h.size).u16(static_cast<std::uint16_t>(h.type)).u16(h.device).u32(h.sequence).u32(h.flags).i64(h.time.ns);
  return put.written();
}

std::size_t encode(const Hello& m, std::byte* out) noexcept {
  Put put(out);
  put.u32(kMagic).u16(m.version).u16(static_cast<std::uint16_t>(m.mode)).f64(m.rate).u64(m.seed);
  put.u32(m.accepts_shared_memory ? 1 : 0).u32(0).name(m.robot);
  return put.written();
}

std::size_t encode(const Welcome& m, std::byte* out) {
  Put put(out);
  put.u32(kMagic).u16(m.version).u16(static_cast<std::uint16_t>(m.devices.size())).i64(m.step.count()).u64(m.seed);
  put.u64(m.shared_bytes).u64(0).name(m.plant);
  for (const DeviceInfo& d : m.devices) {
    put.u16(static_cast<std::uint16_t>(d.kind)).u16(0).u32(d.channels).i64(d.period.count()).i64(d.latency.count());
    put.u32(d.width).u32(d.height).u32(static_cast<std::uint32_t>(d.format)).u32(d.slots).u64(d.slots_offset);
    put.u32(d.slot_bytes).u32(0).name(d.name).u64(0);
  }
  return put.written();
}

std::size_t encode(const ClockInfo& m, std::byte* out) noexcept {
  return Put(out).i64(m.host_ns).f64(m.rate).written();
}

std::size_t encode(const ClockAsk& m, std::byte* out) noexcept { return Put(out).i64(m.asked_ns).written(); }

std::size_t encode(const ClockAnswer& m, std::byte* out) noexcept {
  return Put(out).i64(m.asked_ns).i64(m.received_ns).i64(m.answered_ns).written();
}

std::size_t encode(const Command& m, std::byte* out) noexcept {
  Put put(out);
  put.i64(m.lease.count()).i64(m.setpoints.stamp.ns).u32(m.setpoints.count).u32(m.setpoints.armed);
  for (std::size_t i = 0; i < msg::kMaxChannels; ++i) put.f64(i < m.setpoints.count ? m.setpoints.value[i] : 0.0);
  return put.written();
}

std::size_t encode(const Sample<msg::ImuSample>& m, std::byte* out) noexcept {
  return Put(out).i64(m.ready.ns).vec(m.value.gyro_radps).vec(m.value.accel_mps2).written();
}

std::size_t encode(const Sample<msg::RangeSample>& m, std::byte* out) noexcept {
  return Put(out).i64(m.ready.ns).f64(m.value.range_m).written();
}

std::size_t encode(const Sample<msg::BaroSample>& m, std::byte* out) noexcept {
  return Put(out).i64(m.ready.ns).f64(m.value.pressure_pa).f64(m.value.temperature_c).written();
}

std::size_t encode(const Sample<msg::BatterySample>& m, std::byte* out) noexcept {
  return Put(out).i64(m.ready.ns).f64(m.value.voltage_v).f64(m.value.current_a).f64(m.value.charge).written();
}

std::size_t encode(const Sample<msg::SolePressure>& m, std::byte* out) noexcept {
  Put put(out);
  put.i64(m.ready.ns);
  for (const double force_n : m.value.force_n) put.f64(force_n);
  return put.written();
}

std::size_t encode(const Sample<msg::RefereeState>& m, std::byte* out) noexcept {
  const msg::RefereeState& s = m.value;
  Put put(out);
  put.i64(m.ready.ns).f64(s.left_s).f64(s.penalty_left_s).u32(static_cast<std::uint32_t>(s.phase));
  put.u32(static_cast<std::uint32_t>(s.penalty)).u32(static_cast<std::uint32_t>(s.kick)).u32(s.half);
  put.u32(s.own_goals).u32(s.other_goals).u32(s.team).u32(s.attacks_right);
  return put.written();
}

std::size_t encode(const Sample<msg::JointState>& m, std::byte* out) noexcept {
  const msg::JointState& s = m.value;
  const std::size_t count = std::clamp<std::size_t>(s.count, 1, msg::kMaxChannels);
  Put put(out);
  put.i64(m.ready.ns).u32(static_cast<std::uint32_t>(count)).u32(s.ready);
  for (std::size_t i = 0; i < count; ++i) {
    put.i64(s.measured[i].ns).f64(s.position_rad[i]).f64(s.velocity_radps[i]).f64(s.effort_nm[i]);
    put.f32(s.temperature_c[i]).f32(s.voltage_v[i]).u32(static_cast<std::uint32_t>(s.mode[i]));
    put.u32(s.faults[i]).u32(s.fault_code[i]).u32(0);
  }
  return put.written();
}

std::size_t encode(const Sample<msg::Datagram>& m, std::byte* out) noexcept {
  const std::span<const std::uint8_t> bytes = m.value.bytes();
  Put put(out);
  put.i64(m.ready.ns).u32(m.value.sender).u32(static_cast<std::uint32_t>(bytes.size()));
  std::memcpy(out + put.written(), bytes.data(), bytes.size());
  return put.written() + bytes.size();
}

std::size_t encode(const Transmission& m, std::byte* out) noexcept {
  std::memcpy(out, m.data.data(), m.size);
  return m.size;
}

std::size_t encode(const FrameInfo& m, std::byte* out) noexcept {
  Put put(out);
  put.i64(m.ready.ns).i64(m.exposure_ns).u32(m.number).u32(m.width).u32(m.height);
  put.u32(static_cast<std::uint32_t>(m.format)).u32(m.slot).u32(m.generation);
  return put.written();
}

std::size_t encode(const Truth& m, std::byte* out) noexcept {
  Put put(out);
  const msg::Quat& q = m.q_world_base;
  put.vec(m.p_world_m).vec(m.v_world_mps).f64(q.w).f64(q.x).f64(q.y).f64(q.z).vec(m.gyro_radps).vec(m.pad_world_m);
  put.f64(m.battery_v).u32(m.contact).u32(m.landed);
  return put.written();
}

Status decode(Bytes from, Header& out) noexcept {
  if (from.size() < kHeaderBytes) return bad("header is cut off", std::int64_t(from.size()));
  Get get(from);
  out.size = get.u32();
  out.type = static_cast<Type>(get.u16());
  out.device = get.u16();
  out.sequence = get.u32();
  out.flags = get.u32();
  out.time.ns = get.i64();
  Sizes sizes{};
  if (auto known = sizes_of(out.type, sizes); !known) return known;
  if (out.size < kHeaderBytes + sizes.least || out.size > kHeaderBytes + sizes.most)
    return bad("message has the wrong size for its type", out.size);
  if (out.flags != 0) return bad("unknown header flags", out.flags);
  if (!is_time(out.time.ns)) return bad("time is out of range", out.time.ns);
  return {};
}

Status decode(const Header&, Bytes payload, Hello& out) {
  if (payload.size() < 8) return bad("Hello is cut off", std::int64_t(payload.size()));
  Get get(payload);
  if (const auto magic = get.u32(); magic != kMagic) return bad("peer does not speak the simulator protocol", magic);
  out.version = get.u16();
  if (out.version != kVersion) return bad("peer speaks another version of the simulator protocol", out.version);
  if (auto ok = expect_size(payload, kHelloBytes); !ok) return ok;
  out.mode = static_cast<Mode>(get.u16());
  out.rate = get.f64();
  out.seed = get.u64();
  out.accepts_shared_memory = (get.u32() & 1) != 0;
  get.u32();
  if (!get.name(out.robot)) return bad("robot has no proper name");
  if (out.mode != Mode::lockstep && out.mode != Mode::free_running && out.mode != Mode::side_line)
    return bad("unknown mode", std::int64_t(out.mode));
  if (!is_rate(out.rate)) return bad("rate is not from 0.001 to 1000");
  return {};
}

Status decode(const Header&, Bytes payload, Welcome& out) {
  if (payload.size() < 8) return bad("Welcome is cut off", std::int64_t(payload.size()));
  Get get(payload);
  if (const auto magic = get.u32(); magic != kMagic) return bad("peer does not speak the simulator protocol", magic);
  out.version = get.u16();
  if (out.version != kVersion) return bad("peer speaks another version of the simulator protocol", out.version);
  const std::size_t count = get.u16();
  if (count > kMaxDevices) return bad("too many devices", std::int64_t(count));
  if (auto ok = expect_size(payload, kWelcomeBytes + count * kDeviceBytes); !ok) return ok;
  out.step = Duration(get.i64());
  out.seed = get.u64();
  out.shared_bytes = get.u64();
  get.u64();
  if (!get.name(out.plant)) return bad("plant has no proper name");
  if (out.step.count() <= 0 || !is_time(out.step.count())) return bad("plant's step is not positive", out.step.count());
  out.devices.assign(count, {});
  for (std::size_t i = 0; i < count; ++i) {
    if (auto ok = decode_device(get, out.shared_bytes, out.devices[i]); !ok) return ok;
    for (std::size_t j = 0; j < i; ++j)
      if (out.devices[j].name == out.devices[i].name) return bad("two devices have the same name", std::int64_t(i));
  }
  return {};
}

Status decode(const Header&, Bytes payload, ClockInfo& out) noexcept {
  if (auto ok = expect_size(payload, kClockBytes); !ok) return ok;
  Get get(payload);
  out.host_ns = get.i64();
  out.rate = get.f64();
  if (!is_time(out.host_ns)) return bad("host clock is out of range", out.host_ns);
  if (!is_rate(out.rate)) return bad("rate is not from 0.001 to 1000");
  return {};
}

Status decode(const Header&, Bytes payload, ClockAsk& out) noexcept {
  if (auto ok = expect_size(payload, kClockAskBytes); !ok) return ok;
  out.asked_ns = Get(payload).i64();
  if (!is_time(out.asked_ns)) return bad("host clock is out of range", out.asked_ns);
  return {};
}

Status decode(const Header&, Bytes payload, ClockAnswer& out) noexcept {
  if (auto ok = expect_size(payload, kClockAnswerBytes); !ok) return ok;
  Get get(payload);
  out.asked_ns = get.i64(), out.received_ns = get.i64(), out.answered_ns = get.i64();
  for (const std::int64_t ns : {out.asked_ns, out.received_ns, out.answered_ns})
    if (!is_time(ns)) return bad("host clock is out of range", ns);
  if (out.answered_ns < out.received_ns) return bad("clock was answered before it was asked", out.answered_ns);
  return {};
}

Status decode(const Header&, Bytes payload, Command& out) noexcept {
  if (auto ok = expect_size(payload, kCommandBytes); !ok) return ok;
  Get get(payload);
  out.lease = Duration(get.i64());
  out.setpoints.stamp.ns = get.i64();
  out.setpoints.count = get.u32();
  out.setpoints.armed = get.u32();
  for (double& value : out.setpoints.value) value = get.f64();
  if (out.lease.count() <= 0 || !is_time(out.lease.count())) return bad("lease is not positive", out.lease.count());
  if (out.setpoints.count == 0 || out.setpoints.count > msg::kMaxChannels)
    return bad("command has no or too many setpoints", out.setpoints.count);
  if (out.setpoints.armed > 1) return bad("armed is neither 0 nor 1", out.setpoints.armed);
  for (std::size_t i = 0; i < out.setpoints.count; ++i)
    if (!std::isfinite(out.setpoints.value[i])) return bad("setpoint is not a finite number", std::int64_t(i));
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::ImuSample>& out) noexcept {
  if (auto ok = expect_size(payload, kImuBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.value.stamp = h.time;
  out.value.gyro_radps = get.vec();
  out.value.accel_mps2 = get.vec();
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::RangeSample>& out) noexcept {
  if (auto ok = expect_size(payload, kRangeBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.value.stamp = h.time;
  out.value.range_m = get.f64();
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::BaroSample>& out) noexcept {
  if (auto ok = expect_size(payload, kBaroBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.value.stamp = h.time;
  out.value.pressure_pa = get.f64();
  out.value.temperature_c = get.f64();
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::BatterySample>& out) noexcept {
  if (auto ok = expect_size(payload, kBatteryBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.value.stamp = h.time;
  out.value.voltage_v = get.f64();
  out.value.current_a = get.f64();
  out.value.charge = get.f64();
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::SolePressure>& out) noexcept {
  if (auto ok = expect_size(payload, kSolesBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.value.stamp = h.time;
  for (double& force_n : out.value.force_n) force_n = get.f64();
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::RefereeState>& out) noexcept {
  if (auto ok = expect_size(payload, kRefereeBytes); !ok) return ok;
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  msg::RefereeState& s = out.value;
  s.stamp = h.time;
  s.left_s = get.f64(), s.penalty_left_s = get.f64();
  s.phase = static_cast<msg::GamePhase>(get.u32());
  s.penalty = static_cast<msg::GamePenalty>(get.u32());
  s.kick = static_cast<msg::GameKick>(get.u32());
  s.half = get.u32(), s.own_goals = get.u32(), s.other_goals = get.u32();
  s.team = get.u32(), s.attacks_right = get.u32();
  if (s.phase > msg::GamePhase::finished) return bad("unknown phase of a game", std::int64_t(s.phase));
  if (s.penalty > msg::GamePenalty::other) return bad("unknown penalty", std::int64_t(s.penalty));
  if (s.kick > msg::GameKick::other) return bad("unknown team to kick", std::int64_t(s.kick));
  if (s.team > 1 || s.attacks_right > 1) return bad("team or direction is neither 0 nor 1", s.team);
  if (!std::isfinite(s.left_s) || !std::isfinite(s.penalty_left_s)) return bad("a game's time is no finite number");
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::JointState>& out) noexcept {
  constexpr std::uint32_t kKnownFaults = 2 * msg::kJointDuplicate - 1;
  if (payload.size() < kJointsHeadBytes) return bad("Joints is cut off", std::int64_t(payload.size()));
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  msg::JointState& s = out.value;
  s = {};
  s.stamp = h.time;
  s.count = get.u32();
  s.ready = get.u32();
  if (s.count == 0 || s.count > msg::kMaxChannels) return bad("joints are 1 to 8", s.count);
  if (auto ok = expect_size(payload, kJointsHeadBytes + s.count * kJointBytes); !ok) return ok;
  if (s.ready >> s.count != 0) return bad("a joint that does not exist is ready", s.ready);
  for (std::size_t i = 0; i < s.count; ++i) {
    s.measured[i].ns = get.i64();
    s.position_rad[i] = get.f64(), s.velocity_radps[i] = get.f64(), s.effort_nm[i] = get.f64();
    s.temperature_c[i] = get.f32(), s.voltage_v[i] = get.f32();
    s.mode[i] = static_cast<msg::JointMode>(get.u32());
    s.faults[i] = get.u32(), s.fault_code[i] = get.u32();
    get.u32();
    if (!is_time(s.measured[i].ns) || s.measured[i] > out.ready)
      return bad("joint was measured after it is ready", s.measured[i].ns);
    if (s.mode[i] > msg::JointMode::homing) return bad("unknown mode of a joint", std::int64_t(s.mode[i]));
    if (s.faults[i] > kKnownFaults) return bad("unknown fault of a joint", s.faults[i]);
  }
  return {};
}

Status decode(const Header& h, Bytes payload, Sample<msg::Datagram>& out) noexcept {
  if (payload.size() <= kDatagramHeadBytes) return bad("Datagram is cut off", std::int64_t(payload.size()));
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  msg::Datagram& d = out.value;
  d.stamp = h.time;
  d.sender = get.u32();
  d.port = d.lost = 0;
  d.size = get.u32();
  if (d.size > msg::kMaxDatagramBytes || payload.size() != kDatagramHeadBytes + d.size)
    return bad("Datagram does not have the size that it says", d.size);
  std::memcpy(d.data.data(), payload.data() + kDatagramHeadBytes, d.size);
  std::memset(d.data.data() + d.size, 0, d.data.size() - d.size);
  return {};
}

Status decode(const Header&, Bytes payload, Transmission& out) noexcept {
  if (payload.empty() || payload.size() > out.data.size())
    return bad("Transmit is empty or too long", std::int64_t(payload.size()));
  out.size = static_cast<std::uint32_t>(payload.size());
  std::memcpy(out.data.data(), payload.data(), payload.size());
  return {};
}

Status decode(const Header& h, Bytes payload, FrameInfo& out) noexcept {
  if (payload.size() < kFrameBytes) return bad("Frame is cut off", std::int64_t(payload.size()));
  Get get(payload);
  if (auto ok = decode_ready(h, get, out.ready); !ok) return ok;
  out.exposure_ns = get.i64();
  out.number = get.u32();
  out.width = get.u32(), out.height = get.u32();
  out.format = static_cast<msg::PixelFormat>(get.u32());
  out.slot = get.u32(), out.generation = get.u32();
  if (!is_time(out.exposure_ns)) return bad("exposure is out of range", out.exposure_ns);
  const std::uint32_t depth = msg::bytes_per_pixel(out.format);
  if (depth == 0) return bad("unknown pixel format", std::int64_t(out.format));
  if (out.width == 0 || out.width > msg::kMaxImageWidth || out.height == 0 || out.height > msg::kMaxImageHeight)
    return bad("frame is larger than 1280x960 or empty", out.width);
  const std::uint32_t pixels = out.slot == kInStream ? out.width * out.height * depth : 0;
  if (h.size != kHeaderBytes + kFrameBytes + pixels) return bad("frame has the wrong number of pixels", h.size);
  if (out.slot != kInStream && out.generation == 0) return bad("frame slot has no generation", out.slot);
  return {};
}

Status decode(const Header&, Bytes payload, Truth& out) noexcept {
  if (auto ok = expect_size(payload, kTruthBytes); !ok) return ok;
  Get get(payload);
  out.p_world_m = get.vec();
  out.v_world_mps = get.vec();
  msg::Quat& q = out.q_world_base;
  q.w = get.f64(), q.x = get.f64(), q.y = get.f64(), q.z = get.f64();
  out.gyro_radps = get.vec();
  out.pad_world_m = get.vec();
  out.battery_v = get.f64();
  out.contact = get.u32(), out.landed = get.u32();
  return {};
}

std::string describe_failure(const Error& error, std::string_view what) {
  std::string text(what);
  text += std::string(": ") + hal::to_string(error.code) + ": " + error.where;
  if (error.detail != 0) text += " (" + std::to_string(error.detail) + ")";
  return text;
}

std::string decode_text(Bytes payload) {
  std::string text(reinterpret_cast<const char*>(payload.data()), std::min(payload.size(), kMaxTextBytes));
  // A peer's text reaches terminals: control characters would be commands there. UTF-8 stays.
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool c1 = c >= 0x80 && c < 0xA0 && (i == 0 || static_cast<unsigned char>(text[i - 1]) == 0xC2);
    if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7F || c1) text[i] = '?';
  }
  return text;
}

}  // namespace sinew::sim_hil
