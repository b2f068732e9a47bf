#pragma once
// The simulator protocol, byte by byte, little-endian, as docs/sim-protocol.md has it: what a plant and a runtime say
// to each other. Pure: bytes in, values out, and back. Sockets are hal's matter, devices sim_board.hpp's and
// plant_link.hpp's.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"
#include "msg/actuators.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "msg/radio.hpp"
#include "msg/referee.hpp"
#include "msg/sensors.hpp"

namespace sinew::sim_hil {

using hal::Duration;
using hal::Time;

inline constexpr std::uint32_t kMagic = 0x50574E53;  // the bytes "SNWP"
inline constexpr std::uint16_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 24;
inline constexpr std::size_t kNameBytes = 32;                      // zero-padded, at most 31 characters
inline constexpr std::size_t kMaxDevices = 32;                     // a device's id is its place in the Welcome
inline constexpr std::size_t kMaxTextBytes = 60 * 1024;            // Bye and Report
inline constexpr std::size_t kSlotHeaderBytes = 64;                // of a frame slot in shared memory
inline constexpr std::uint32_t kInStream = 0xFFFFFFFF;             // FrameInfo::slot: the pixels follow the message
inline constexpr std::uint16_t kAllGroups = 0xFFFF;                // device of a Stop
inline constexpr std::int64_t kMaxTimeNs = std::int64_t{1} << 62;  // 146 years; keeps sums of two times in range

/// Numbers on the wire. Direction: r = runtime to plant, p = plant to runtime.
enum class Type : std::uint16_t {
  hello = 1,          // r  the first message of all
  welcome = 2,        // p  the answer; its memory handle travels with it
  start = 3,          // r  configured; the plant's time begins to run
  clock = 4,          // p  free-running: answer to start
  grant = 5,          // p  lockstep: every sample with ready <= time has been sent
  done = 6,           // r  lockstep: every command with commit <= time has been sent
  command = 7,        // r  setpoints of one actuator group
  stop = 8,           // r  safe action at once
  bye = 9,            // rp the reason, as text; the last message
  stopped = 10,       // p  side line: answer to stop
  transmit = 11,      // r  a datagram that a radio sends
  imu = 16,           // p
  range = 17,         // p
  baro = 18,          // p
  frame = 19,         // p
  battery = 20,       // p
  joints = 21,        // p
  datagram = 22,      // p  one that a radio hears
  soles = 23,         // p
  truth = 24,         // p  for the report only, never for a module
  report = 25,        // p  JSON text about the plant's health
  referee = 26,       // p
  clock_ask = 32,     // r  side line: what does your host's clock show?
  clock_answer = 33,  // p  side line
};

/// Why the peer has connected. A side line is a second, independent connection beside the runtime's: it can stop all
/// actuators, and compare clocks without waiting behind samples and pixels.
enum class Mode : std::uint16_t { lockstep = 0, free_running = 1, side_line = 2 };
enum class DeviceKind : std::uint16_t {
  imu = 1,
  range = 2,
  baro = 3,
  camera = 4,
  actuators = 5,
  battery = 6,
  joints = 7,
  radio = 8,
  soles = 9,
  referee = 10
};

/// A name as the wire carries it: of letters, digits, '_', '-' and '.', not empty and below kNameBytes.
bool is_name(std::string_view text);
std::string_view to_string(Type type);
std::string_view to_string(DeviceKind kind);

struct Header {
  std::uint32_t size = 0;  // of the whole message, this header included
  Type type{};
  std::uint16_t device = 0;    // place in the Welcome's list; 0 where no device is meant
  std::uint32_t sequence = 0;  // counts the messages of one direction from 0; a stream loses none
  std::uint32_t flags = 0;     // none defined yet
  Time time;                   // each type defines its meaning
};

struct Hello {
  std::uint16_t version = kVersion;
  Mode mode = Mode::lockstep;
  double rate = 1.0;  // plant seconds per real second, free-running only
  std::uint64_t seed = 0;
  bool accepts_shared_memory = false;
  std::string robot;
};

/// One line of the Welcome's list.
struct DeviceInfo {
  DeviceKind kind = DeviceKind::imu;
  std::string name;
  Duration period{0};          // 0: at no fixed period
  Duration latency{0};         // nominal, from stamp to ready
  std::uint32_t channels = 0;  // actuators: setpoints of the group; joints: how many there are
  std::uint32_t width = 0, height = 0;
  msg::PixelFormat format = msg::PixelFormat::none;
  std::uint32_t slots = 0;         // camera: frame slots in shared memory; 0: in the stream
  std::uint64_t slots_offset = 0;  // of the first slot
  std::uint32_t slot_bytes = 0;    // from slot to slot

  std::uint32_t frame_bytes() const { return width * height * msg::bytes_per_pixel(format); }
};

struct Welcome {
  std::uint16_t version = kVersion;
  Duration step{0};  // the plant's own step
  std::uint64_t seed = 0;
  std::uint64_t shared_bytes = 0;  // of the memory passed along; 0: none
  std::string plant;
  std::vector<DeviceInfo> devices;
};

/// Header time: plant time at the instant when the plant's host clock (CLOCK_MONOTONIC on Linux) showed host_ns.
struct ClockInfo {
  std::int64_t host_ns = 0;
  double rate = 1.0;
};

/// Three of the four time stamps of a clock exchange: the asker's host clock as it asked, the plant's host clock as it
/// received and as it answered. The fourth is when the answer arrives.
struct ClockAsk {
  std::int64_t asked_ns = 0;
};
struct ClockAnswer {
  std::int64_t asked_ns = 0, received_ns = 0, answered_ns = 0;
};

/// Header time: the commit. Acts from the first plant step at or after it until commit + lease.
struct Command {
  Duration lease{0};
  msg::ActuatorCommand setpoints;
};

/// Header time: the commit. What the plant's air makes of it is its own matter.
struct Transmission {
  std::uint32_t size = 0;  // 1 to msg::kMaxDatagramBytes
  std::array<std::uint8_t, msg::kMaxDatagramBytes> data;

  std::span<const std::uint8_t> bytes() const { return {data.data(), size}; }
};

/// Header time: the stamp, also that of the value. M is one of ImuSample, RangeSample, BaroSample, BatterySample,
/// JointState, SolePressure, RefereeState, Datagram (its size, sender and bytes; the rest is 0).
template <class M>
struct Sample {
  Time ready;  // when the driver may see it; never before the stamp
  M value;
};

/// Header time: middle of the exposure. The pixels follow, or wait in a slot of the shared memory.
struct FrameInfo {
  Time ready;
  std::int64_t exposure_ns = 0;
  std::uint32_t number = 0;  // counted by the plant's camera
  std::uint32_t width = 0, height = 0;
  msg::PixelFormat format = msg::PixelFormat::none;
  std::uint32_t slot = kInStream;
  std::uint32_t generation = 0;  // what the slot's first word must read before and after the copy
};

/// Header time: plant time. World is ENU.
struct Truth {
  msg::Vec3 p_world_m, v_world_mps;
  msg::Quat q_world_base;
  msg::Vec3 gyro_radps;
  msg::Vec3 pad_world_m;
  double battery_v = 0;
  std::uint32_t contact = 0;  // 1: something touches the ground
  std::uint32_t landed = 0;   // 1: all feet on the ground
};

// Bytes behind the header; messages of fixed size carry exactly these.
inline constexpr std::size_t kHelloBytes = 64, kWelcomeBytes = 72, kDeviceBytes = 96, kClockBytes = 16;
inline constexpr std::size_t kCommandBytes = 88, kImuBytes = 56, kRangeBytes = 16, kBaroBytes = 24, kFrameBytes = 40;
inline constexpr std::size_t kBatteryBytes = 32, kSolesBytes = 72, kRefereeBytes = 56, kTruthBytes = 144,
                             kClockAskBytes = 8, kClockAnswerBytes = 24;
inline constexpr std::size_t kJointsHeadBytes = 16, kJointBytes = 56;  // a Joints: its head, then joint by joint
inline constexpr std::size_t kDatagramHeadBytes = 16;                  // then the bytes; a Transmit is only these
inline constexpr std::size_t kMaxMessageBytes =
    kHeaderBytes + kFrameBytes + std::size_t{msg::kMaxImageWidth} * msg::kMaxImageHeight * 3;
inline constexpr std::size_t kMaxSmallBytes = kHeaderBytes + kMaxTextBytes;  // everything but pixels

using Bytes = std::span<const std::byte>;

// Encoders write the payload to `out` (at least the size above) and return the bytes written.
// RT: yes, except the Welcome's. Names are cut at 31 characters, and what the page does not allow becomes '_'.
std::size_t encode(const Header& h, std::byte* out) noexcept;
std::size_t encode(const Hello& m, std::byte* out) noexcept;
std::size_t encode(const Welcome& m, std::byte* out);  // kWelcomeBytes + devices * kDeviceBytes
std::size_t encode(const ClockInfo& m, std::byte* out) noexcept;
std::size_t encode(const ClockAsk& m, std::byte* out) noexcept;
std::size_t encode(const ClockAnswer& m, std::byte* out) noexcept;
std::size_t encode(const Command& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::ImuSample>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::RangeSample>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::BaroSample>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::BatterySample>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::SolePressure>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::RefereeState>& m, std::byte* out) noexcept;
std::size_t encode(const Sample<msg::JointState>& m, std::byte* out) noexcept;  // at most kMaxChannels of its joints
std::size_t encode(const Sample<msg::Datagram>& m, std::byte* out) noexcept;
std::size_t encode(const Transmission& m, std::byte* out) noexcept;
std::size_t encode(const FrameInfo& m, std::byte* out) noexcept;
std::size_t encode(const Truth& m, std::byte* out) noexcept;

// Decoders trust nothing: they check sizes, times, enumerations, counts and names. Payload: the bytes behind `h`.
// Errors:  bad_data; `where` names the rule, `detail` is the offending number. Out is then unspecified.
hal::Status decode(Bytes from, Header& out) noexcept;  // at least kHeaderBytes
hal::Status decode(const Header& h, Bytes payload, Hello& out);
hal::Status decode(const Header& h, Bytes payload, Welcome& out);
hal::Status decode(const Header& h, Bytes payload, ClockInfo& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, ClockAsk& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, ClockAnswer& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Command& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::ImuSample>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::RangeSample>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::BaroSample>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::BatterySample>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::SolePressure>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::RefereeState>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::JointState>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Sample<msg::Datagram>& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, Transmission& out) noexcept;
hal::Status decode(const Header& h, Bytes payload, FrameInfo& out) noexcept;  // the first kFrameBytes of the payload
hal::Status decode(const Header& h, Bytes payload, Truth& out) noexcept;
/// For people: "what: where (detail)".
std::string describe_failure(const hal::Error& error, std::string_view what);
std::string decode_text(Bytes payload);  // Bye, Report: control characters become '?'

}  // namespace sinew::sim_hil
