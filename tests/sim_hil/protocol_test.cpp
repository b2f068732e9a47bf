#include "sim_hil/protocol.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "sim_hil/message_io.hpp"

namespace sinew::sim_hil::protocol_test {
namespace {

using hal::Errc;
using namespace std::chrono_literals;

Welcome flying_plant() {
  Welcome w;
  w.step = 250us;
  w.seed = 7;
  w.plant = "quad";
  w.shared_bytes = 4096;
  w.devices.resize(3);
  w.devices[0].kind = DeviceKind::imu, w.devices[0].name = "imu", w.devices[0].period = 1ms;
  w.devices[1].kind = DeviceKind::actuators, w.devices[1].name = "motors", w.devices[1].channels = 4;
  DeviceInfo& camera = w.devices[2];
  camera.kind = DeviceKind::camera, camera.name = "down.camera-1", camera.latency = 20ms;
  camera.width = 16, camera.height = 8, camera.format = msg::PixelFormat::yuyv;
  camera.slots = 4, camera.slots_offset = 64, camera.slot_bytes = 320;
  return w;
}

Sample<msg::JointState> two_joints() {
  Sample<msg::JointState> s;
  s.ready = Time{5000};
  s.value.count = 2, s.value.ready = 1;
  s.value.measured = {Time{4000}, Time{4500}};
  s.value.position_rad = {0.5, -0.0}, s.value.velocity_radps = {-1e-310, 3}, s.value.effort_nm = {0.25, std::nan("")};
  s.value.temperature_c = {41.5, std::nan("")}, s.value.voltage_v = {12.25, 11};
  s.value.mode = {msg::JointMode::enabled, msg::JointMode::fault};
  s.value.faults = {0, msg::kJointOverload}, s.value.fault_code = {0, 0x8611};
  return s;
}

template <class M>
std::vector<std::byte> payload_of(const M& m, std::size_t room = 8192) {
  std::vector<std::byte> out(room);
  out.resize(encode(m, out.data()));
  return out;
}

template <class M>
hal::Status decode_payload(Type type, const std::vector<std::byte>& payload, M& out, Time time = {},
                           std::size_t bulk = 0) {
  Header h;
  h.type = type;
  h.time = time;
  h.size = static_cast<std::uint32_t>(kHeaderBytes + payload.size() + bulk);
  return decode(h, payload, out);
}

TEST(SimProtocol, HeaderStandsOnTheWireAsThePageSays) {
  Header h;
  h.size = 0x01020304, h.type = Type::imu, h.device = 0x0506, h.sequence = 0x0708090A;
  h.time.ns = 0x1112131415161718;
  std::array<std::byte, kHeaderBytes> wire{};
  ASSERT_EQ(encode(h, wire.data()), kHeaderBytes);
  const std::array<std::uint8_t, kHeaderBytes> page = {4, 3, 2, 1, 16, 0,  6,    5,    0x0A, 9,    8,    7,
                                                       0, 0, 0, 0, 24, 23, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11};
  for (std::size_t i = 0; i < kHeaderBytes; ++i) EXPECT_EQ(std::to_integer<int>(wire[i]), page[i]) << i;
}

TEST(SimProtocol, PayloadsHaveTheSizesOfThePage) {
  EXPECT_EQ(payload_of(Hello{}).size(), kHelloBytes);
  EXPECT_EQ(payload_of(flying_plant()).size(), kWelcomeBytes + 3 * kDeviceBytes);
  EXPECT_EQ(payload_of(ClockInfo{}).size(), kClockBytes);
  EXPECT_EQ(payload_of(ClockAsk{}).size(), kClockAskBytes);
  EXPECT_EQ(payload_of(ClockAnswer{}).size(), kClockAnswerBytes);
  EXPECT_EQ(payload_of(Command{}).size(), kCommandBytes);
  EXPECT_EQ(payload_of(Sample<msg::ImuSample>{}).size(), kImuBytes);
  EXPECT_EQ(payload_of(Sample<msg::RangeSample>{}).size(), kRangeBytes);
  EXPECT_EQ(payload_of(Sample<msg::BaroSample>{}).size(), kBaroBytes);
  EXPECT_EQ(payload_of(Sample<msg::BatterySample>{}).size(), kBatteryBytes);
  EXPECT_EQ(payload_of(Sample<msg::SolePressure>{}).size(), kSolesBytes);
  EXPECT_EQ(payload_of(Sample<msg::RefereeState>{}).size(), kRefereeBytes);
  EXPECT_EQ(payload_of(two_joints()).size(), kJointsHeadBytes + 2 * kJointBytes);
  EXPECT_EQ(payload_of(FrameInfo{}).size(), kFrameBytes);
  EXPECT_EQ(payload_of(Truth{}).size(), kTruthBytes);
}

TEST(SimProtocol, ClockExchangeComesBackAndKeepsItsOrder) {
  ClockAsk ask;
  ASSERT_TRUE(decode_payload(Type::clock_ask, payload_of(ClockAsk{77}), ask));
  EXPECT_EQ(ask.asked_ns, 77);
  EXPECT_FALSE(decode_payload(Type::clock_ask, payload_of(ClockAsk{-1}), ask));
  ClockAnswer answer;
  ASSERT_TRUE(decode_payload(Type::clock_answer, payload_of(ClockAnswer{1, 9, 9}), answer));
  EXPECT_EQ(answer.asked_ns, 1);
  EXPECT_EQ(answer.received_ns, 9);
  EXPECT_EQ(answer.answered_ns, 9);
  EXPECT_FALSE(decode_payload(Type::clock_answer, payload_of(ClockAnswer{1, 9, 8}), answer));
  EXPECT_FALSE(decode_payload(Type::clock_answer, payload_of(ClockAnswer{1, 9, kMaxTimeNs + 1}), answer));
}

TEST(SimProtocol, WelcomeComesBackAsItWasSent) {
  Welcome back;
  ASSERT_TRUE(decode_payload(Type::welcome, payload_of(flying_plant()), back));
  EXPECT_EQ(back.plant, "quad");
  EXPECT_EQ(back.step, 250us);
  EXPECT_EQ(back.seed, 7u);
  EXPECT_EQ(back.shared_bytes, 4096u);
  ASSERT_EQ(back.devices.size(), 3u);
  EXPECT_EQ(back.devices[1].channels, 4u);
  EXPECT_EQ(back.devices[2].name, "down.camera-1");
  EXPECT_EQ(back.devices[2].latency, 20ms);
  EXPECT_EQ(back.devices[2].format, msg::PixelFormat::yuyv);
  EXPECT_EQ(back.devices[2].slots_offset, 64u);
  EXPECT_EQ(back.devices[2].slot_bytes, 320u);
}

TEST(SimProtocol, SamplesComeBackWithTheSameBits) {
  Sample<msg::ImuSample> imu;
  imu.ready = Time{5000};
  imu.value.gyro_radps = {-0.0, 1e-310, 3};
  imu.value.accel_mps2 = {std::numeric_limits<double>::infinity(), 5, 6};
  Sample<msg::ImuSample> back;
  ASSERT_TRUE(decode_payload(Type::imu, payload_of(imu), back, Time{4000}));
  EXPECT_EQ(back.value.stamp, Time{4000});
  EXPECT_EQ(back.ready, Time{5000});
  EXPECT_EQ(std::memcmp(&back.value.gyro_radps, &imu.value.gyro_radps, 2 * sizeof(msg::Vec3)), 0);

  Sample<msg::RangeSample> range, range_back;
  range.value.range_m = std::nan("");
  ASSERT_TRUE(decode_payload(Type::range, payload_of(range), range_back));
  EXPECT_TRUE(std::isnan(range_back.value.range_m));

  Sample<msg::BatterySample> battery, battery_back;
  battery.ready = Time{7};
  battery.value.voltage_v = 15.2, battery.value.current_a = 9.5, battery.value.charge = 0.75;
  ASSERT_TRUE(decode_payload(Type::battery, payload_of(battery), battery_back, Time{6}));
  EXPECT_EQ(battery_back.ready, Time{7});
  EXPECT_EQ(battery_back.value.stamp, Time{6});
  EXPECT_EQ(battery_back.value.voltage_v, 15.2);
  EXPECT_EQ(battery_back.value.current_a, 9.5);
  EXPECT_EQ(battery_back.value.charge, 0.75);

  Sample<msg::SolePressure> soles, soles_back;
  soles.ready = Time{7};
  soles.value.force_n = {1, 2, 3, 4, 5, 6, 7, 8};
  ASSERT_TRUE(decode_payload(Type::soles, payload_of(soles), soles_back, Time{6}));
  EXPECT_EQ(soles_back.value.stamp, Time{6});
  EXPECT_EQ(soles_back.value.force_n, soles.value.force_n);
}

TEST(SimProtocol, ARefereesWordComesBackAsItWasSentOrIsRefused) {
  Sample<msg::RefereeState> sent, back;
  sent.ready = Time{9};
  sent.value = {{}, 512.5, 12.25, msg::GamePhase::playing, msg::GamePenalty::incapable, msg::GameKick::own, 2, 3,
                4,  1,     1};
  ASSERT_TRUE(decode_payload(Type::referee, payload_of(sent), back, Time{8}));
  EXPECT_EQ(back.value.stamp, Time{8});
  sent.value.stamp = Time{8};
  EXPECT_EQ(std::memcmp(&back.value, &sent.value, sizeof sent.value), 0);
  const auto refused = [&](auto&& spoil) {
    auto other = sent;
    spoil(other.value);
    return !decode_payload(Type::referee, payload_of(other), back, Time{8});
  };
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.phase = static_cast<msg::GamePhase>(5); }));
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.penalty = static_cast<msg::GamePenalty>(14); }));
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.kick = static_cast<msg::GameKick>(3); }));
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.team = 2; }));
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.attacks_right = 2; }));
  EXPECT_TRUE(refused([](msg::RefereeState& s) { s.left_s = std::nan(""); }));
}

TEST(SimProtocol, CommandAndTruthComeBackAsTheyWereSent) {
  Command c, c_back;
  c.lease = 20ms;
  c.setpoints.stamp = Time{99};
  c.setpoints.count = 2, c.setpoints.armed = 1, c.setpoints.value = {0.25, 0.5, 77.0};
  ASSERT_TRUE(decode_payload(Type::command, payload_of(c), c_back));
  EXPECT_EQ(c_back.lease, 20ms);
  EXPECT_EQ(c_back.setpoints.stamp, Time{99});
  EXPECT_EQ(c_back.setpoints.value[1], 0.5);
  EXPECT_EQ(c_back.setpoints.value[2], 0.0) << "an unused channel is sent as 0";

  Truth t, t_back;
  t.p_world_m = {1, 2, 3}, t.q_world_base = {0.5, 0.5, 0.5, 0.5}, t.battery_v = 11.1, t.landed = 1;
  ASSERT_TRUE(decode_payload(Type::truth, payload_of(t), t_back));
  EXPECT_EQ(t_back.p_world_m, t.p_world_m);
  EXPECT_EQ(t_back.q_world_base, t.q_world_base);
  EXPECT_EQ(t_back.battery_v, 11.1);
  EXPECT_EQ(t_back.landed, 1u);
}

TEST(SimProtocol, JointsComeBackWithTheSameBitsJointByJoint) {
  const auto sent = two_joints();
  Sample<msg::JointState> back;
  ASSERT_TRUE(decode_payload(Type::joints, payload_of(sent), back, Time{4000}));
  EXPECT_EQ(back.ready, Time{5000});
  EXPECT_EQ(back.value.stamp, Time{4000});
  EXPECT_EQ(back.value.count, 2u);
  EXPECT_EQ(back.value.ready, 1u);
  EXPECT_EQ(back.value.measured, sent.value.measured);
  EXPECT_EQ(std::memcmp(&back.value.position_rad, &sent.value.position_rad, 3 * sizeof(sent.value.position_rad)), 0);
  EXPECT_EQ(back.value.temperature_c[0], 41.5);
  EXPECT_TRUE(std::isnan(back.value.temperature_c[1]));
  EXPECT_EQ(back.value.voltage_v, sent.value.voltage_v);
  EXPECT_EQ(back.value.mode, sent.value.mode);
  EXPECT_EQ(back.value.faults, sent.value.faults);
  EXPECT_EQ(back.value.fault_code, sent.value.fault_code);
}

TEST(SimProtocol, AllEightJointsFitIntoAWriterOfSmallMessages) {
  Sample<msg::JointState> s;
  s.value.count = msg::kMaxChannels;
  MessageWriter writer(kHeaderBytes + kJointsHeadBytes + msg::kMaxChannels * kJointBytes);
  ASSERT_TRUE(writer.add(Type::joints, 0, Time{}, s));
  EXPECT_EQ(writer.room(), 0u);
  EXPECT_FALSE(writer.add(Type::joints, 0, Time{}, s));
}

// ---- refusals, each for its own reason

template <class M>
std::string refusal(Type type, const std::vector<std::byte>& payload, Time time = {}, std::size_t bulk = 0) {
  M out;
  const auto status = decode_payload(type, payload, out, time, bulk);
  if (status) return "accepted";
  EXPECT_EQ(status.error().code, Errc::bad_data);
  return status.error().where;
}

TEST(SimProtocol, HelloOfAnotherVersionNamesThatVersion) {
  Hello h, out;
  h.version = 9;
  const auto status = decode_payload(Type::hello, payload_of(h), out);
  ASSERT_FALSE(status);
  EXPECT_STREQ(status.error().where, "peer speaks another version of the simulator protocol");
  EXPECT_EQ(out.version, 9);
}

TEST(SimProtocol, HelloIsCheckedFieldByField) {
  auto payload = payload_of(Hello{});
  payload[0] = std::byte{0};
  EXPECT_EQ(refusal<Hello>(Type::hello, payload), "peer does not speak the simulator protocol");
  Hello h;
  h.rate = std::nan("");
  EXPECT_EQ(refusal<Hello>(Type::hello, payload_of(h)), "rate is not from 0.001 to 1000");
  h = {};
  h.mode = Mode{3};
  EXPECT_EQ(refusal<Hello>(Type::hello, payload_of(h)), "unknown mode");
  payload = payload_of(Hello{});
  for (std::size_t i = 32; i < 64; ++i) payload[i] = std::byte{'x'};  // no terminator
  EXPECT_EQ(refusal<Hello>(Type::hello, payload), "robot has no proper name");
}

TEST(SimProtocol, WelcomeIsCheckedDeviceByDevice) {
  const auto refused = [](auto change) {
    Welcome w = flying_plant();
    change(w);
    return refusal<Welcome>(Type::welcome, payload_of(w));
  };
  EXPECT_EQ(refused([](Welcome& w) { w.step = 0ns; }), "plant's step is not positive");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[1].name = "imu"; }), "two devices have the same name");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[1].channels = 9; }), "actuators need 1 to 8 channels");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[0].kind = DeviceKind{11}; }), "unknown kind of device");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[0].kind = DeviceKind::joints; }), "joints are 1 to 8");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[0].period = -1ns; }), "device has a bad period or latency");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].width = 1282; }), "camera is larger than 1280x960 or empty");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].width = 15; }), "yuyv needs an even width");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].format = msg::PixelFormat{9}; }), "unknown pixel format");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].slots = 2; }), "camera has too few or too many frame slots");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].slot_bytes = 316; }), "frame slot is too small or not aligned");
  EXPECT_EQ(refused([](Welcome& w) { w.devices[2].slots_offset = 0xFFFFFFFFFFFFFFC0; }),
            "frame slots lie outside of the shared memory");
  EXPECT_EQ(refused([](Welcome& w) { w.shared_bytes = 64 + 4 * 320 - 1; }),
            "frame slots lie outside of the shared memory");
}

TEST(SimProtocol, JointsAreCheckedFieldByField) {
  const auto refused = [](auto change, std::size_t bytes = SIZE_MAX) {
    auto s = two_joints();
    change(s.value);
    auto payload = payload_of(s);
    payload.resize(std::min(payload.size(), bytes));
    return refusal<Sample<msg::JointState>>(Type::joints, payload, Time{4000});
  };
  EXPECT_EQ(refused([](msg::JointState&) {}), "accepted");
  EXPECT_EQ(refused([](msg::JointState&) {}, 15), "Joints is cut off");
  EXPECT_EQ(refused([](msg::JointState&) {}, 127), "message has the wrong size for its type");
  EXPECT_EQ(refused([](msg::JointState& s) { s.ready = 4; }), "a joint that does not exist is ready");
  EXPECT_EQ(refused([](msg::JointState& s) { s.measured[1] = Time{5001}; }), "joint was measured after it is ready");
  EXPECT_EQ(refused([](msg::JointState& s) { s.measured[1] = Time{-1}; }), "joint was measured after it is ready");
  EXPECT_EQ(refused([](msg::JointState& s) { s.mode[0] = msg::JointMode{7}; }), "unknown mode of a joint");
  EXPECT_EQ(refused([](msg::JointState& s) { s.faults[1] = 2048; }), "unknown fault of a joint");
  auto payload = payload_of(two_joints());
  payload[8] = std::byte{9};
  EXPECT_EQ(refusal<Sample<msg::JointState>>(Type::joints, payload, Time{4000}), "joints are 1 to 8");
  EXPECT_EQ(refusal<Sample<msg::JointState>>(Type::joints, payload_of(two_joints()), Time{5001}),
            "sample is ready before it was measured");
}

TEST(SimProtocol, CommandIsCheckedFieldByField) {
  const auto refused = [](auto change) {
    Command c;
    c.lease = 20ms, c.setpoints.count = 4, c.setpoints.armed = 1;
    change(c);
    return refusal<Command>(Type::command, payload_of(c));
  };
  EXPECT_EQ(refused([](Command&) {}), "accepted");
  EXPECT_EQ(refused([](Command& c) { c.lease = 0ns; }), "lease is not positive");
  EXPECT_EQ(refused([](Command& c) { c.setpoints.count = 0; }), "command has no or too many setpoints");
  EXPECT_EQ(refused([](Command& c) { c.setpoints.count = 9; }), "command has no or too many setpoints");
  EXPECT_EQ(refused([](Command& c) { c.setpoints.armed = 2; }), "armed is neither 0 nor 1");
  EXPECT_EQ(refused([](Command& c) { c.setpoints.value[3] = std::nan(""); }), "setpoint is not a finite number");
}

TEST(SimProtocol, SampleThatIsReadyBeforeItWasMeasuredIsRefused) {
  Sample<msg::BaroSample> baro;
  baro.ready = Time{999};
  EXPECT_EQ(refusal<Sample<msg::BaroSample>>(Type::baro, payload_of(baro), Time{1000}),
            "sample is ready before it was measured");
}

TEST(SimProtocol, FrameMustCarryExactlyItsPixels) {
  FrameInfo f;
  f.width = 16, f.height = 8, f.format = msg::PixelFormat::yuyv;
  EXPECT_EQ(refusal<FrameInfo>(Type::frame, payload_of(f), {}, 256), "accepted");
  EXPECT_EQ(refusal<FrameInfo>(Type::frame, payload_of(f), {}, 255), "frame has the wrong number of pixels");
  f.slot = 1;
  EXPECT_EQ(refusal<FrameInfo>(Type::frame, payload_of(f), {}, 256), "frame has the wrong number of pixels");
  EXPECT_EQ(refusal<FrameInfo>(Type::frame, payload_of(f)), "frame slot has no generation");
}

TEST(SimProtocol, TextOfThePeerCannotCommandATerminal) {
  const std::string evil = "ok\x1b[2J\x07\x7f\xc2\x9b gr\xc3\xbc\xc3\x9f\n";
  EXPECT_EQ(decode_text(std::as_bytes(std::span(evil))), "ok?[2J??\xc2? gr\xc3\xbc\xc3\x9f\n");
}

// ---- framing

std::vector<std::byte> conversation() {
  MessageWriter w(1 << 16);
  EXPECT_TRUE(w.add(Type::welcome, 0, Time{}, flying_plant()));
  Sample<msg::ImuSample> imu;
  imu.ready = Time{10};
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(w.add(Type::imu, 0, Time{i}, imu));
  EXPECT_TRUE(w.add(Type::grant, 0, Time{30}));
  EXPECT_TRUE(w.add_text(Type::bye, Time{}, "end"));
  return {w.pending().begin(), w.pending().end()};
}

/// Feeds bytes in chunks; how many messages came out, and the error, if any.
struct Outcome {
  int messages = 0;
  std::string error;
};
Outcome feed(const std::vector<std::byte>& bytes, std::size_t chunk, Sender peer = Sender::plant) {
  MessageReceiver reader(peer);
  Outcome outcome;
  for (std::size_t at = 0; at < bytes.size();) {
    auto space = reader.space();
    const std::size_t n = std::min({chunk, bytes.size() - at, space.size()});
    std::memcpy(space.data(), bytes.data() + at, n);
    reader.filled(n);
    at += n;
    for (Message m;;) {
      auto next = reader.next(m);
      if (!next) {
        outcome.error = next.error().where;
        return outcome;
      }
      if (!*next) break;
      ++outcome.messages;
    }
  }
  return outcome;
}

TEST(SimFraming, MessagesComeOutWhereverTheStreamIsCut) {
  for (std::size_t chunk : {1u, 7u, 24u, 25u, 100u, 100000u}) {
    const Outcome o = feed(conversation(), chunk);
    EXPECT_EQ(o.messages, 23) << chunk;
    EXPECT_EQ(o.error, "") << chunk;
  }
}

TEST(SimFraming, TruncatedStreamYieldsOnlyWholeMessages) {
  const auto whole = conversation();
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const Outcome o = feed({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)}, n);
    ASSERT_EQ(o.error, "") << n;
    ASSERT_LT(o.messages, 23) << n;
  }
}

TEST(SimFraming, GapInTheSequenceEndsTheStream) {
  auto bytes = conversation();
  const std::size_t second = kHeaderBytes + kWelcomeBytes + 3 * kDeviceBytes;
  bytes[second + 8] = std::byte{2};
  EXPECT_EQ(feed(bytes, 1000).error, "messages are missing");
  EXPECT_EQ(feed(bytes, 1000).messages, 1);
}

TEST(SimFraming, WrongHeadersAreNamed) {
  const auto broken = [](std::size_t offset, std::uint8_t value) {
    auto bytes = conversation();
    bytes[offset] = std::byte{value};
    return feed(bytes, 50).error;
  };
  EXPECT_EQ(broken(3, 0x7F), "message has the wrong size for its type");
  const std::size_t imu = kHeaderBytes + kWelcomeBytes + 3 * kDeviceBytes;
  EXPECT_EQ(broken(imu, kHeaderBytes + kImuBytes - 1), "message has the wrong size for its type");
  EXPECT_EQ(broken(4, 200), "unknown message type");
  EXPECT_EQ(broken(12, 1), "unknown header flags");
  EXPECT_EQ(broken(23, 0x80), "time is out of range");
  EXPECT_EQ(feed(conversation(), 50, Sender::runtime).error, "message goes in the wrong direction");
}

TEST(SimFraming, PixelsNobodyTakesAreSkipped) {
  MessageWriter w(1 << 16);
  FrameInfo f;
  f.width = 1280, f.height = 960, f.format = msg::PixelFormat::rgb8;
  const std::size_t pixels = 1280 * 960 * 3;
  ASSERT_TRUE(w.add(Type::frame, 0, Time{}, f, pixels));
  std::vector<std::byte> bytes(w.pending().begin(), w.pending().end());
  bytes.resize(bytes.size() + pixels, std::byte{0xAB});
  w.clear();
  ASSERT_TRUE(w.add(Type::grant, 0, Time{1}));
  bytes.insert(bytes.end(), w.pending().begin(), w.pending().end());
  const Outcome o = feed(bytes, 4096);
  EXPECT_EQ(o.error, "");
  EXPECT_EQ(o.messages, 2);
}

TEST(SimFraming, EveryFlippedBitIsEitherHarmlessOrRefused) {
  const auto whole = conversation();
  int refused = 0;
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    auto bytes = whole;
    bytes[bit / 8] ^= std::byte{static_cast<std::uint8_t>(1u << (bit % 8))};
    const Outcome o = feed(bytes, bytes.size());
    ASSERT_LE(o.messages, 23);
    refused += o.error.empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 23 * 8 * 10) << "size, type, sequence and flags of all headers at least";
}

TEST(SimFraming, RandomBytesNeverGetFar) {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::byte> bytes(64 + random() % 512);
    for (auto& b : bytes) b = static_cast<std::byte>(random());
    EXPECT_NE(feed(bytes, 1 + random() % 64).error, "");
  }
}

TEST(SimFraming, WriterRefusesWhatDoesNotFitAndKeepsItsSequence) {
  MessageWriter w(2 * kHeaderBytes + kTruthBytes);
  ASSERT_TRUE(w.add(Type::grant, 0, Time{1}));
  ASSERT_TRUE(w.add(Type::truth, 0, Time{1}, Truth{}));
  EXPECT_FALSE(w.add(Type::grant, 0, Time{2}));
  w.clear();
  ASSERT_TRUE(w.add(Type::grant, 0, Time{2}));
  Header h;
  ASSERT_TRUE(decode(w.pending(), h));
  EXPECT_EQ(h.sequence, 2u);
}

TEST(SimProtocol, DatagramsComeBackAsTheyWere) {
  Sample<msg::Datagram> sent;
  sent.ready = Time{5000};
  sent.value.stamp = Time{4000};
  sent.value.sender = 7;
  sent.value.size = 3;
  sent.value.data = {1, 2, 255};
  const auto payload = payload_of(sent);
  EXPECT_EQ(payload.size(), kDatagramHeadBytes + 3);
  Sample<msg::Datagram> back;
  back.value.data.fill(9);
  ASSERT_TRUE(decode_payload(Type::datagram, payload, back, Time{4000}));
  EXPECT_EQ(back.value.stamp, sent.value.stamp);
  EXPECT_EQ(back.ready, sent.ready);
  EXPECT_EQ(back.value.sender, 7u);
  EXPECT_EQ(back.value.size, 3u);
  EXPECT_EQ(back.value.data, sent.value.data);
  Transmission said;
  said.size = 2;
  said.data[0] = 4, said.data[1] = 5;
  Transmission heard;
  ASSERT_TRUE(decode_payload(Type::transmit, payload_of(said), heard));
  EXPECT_EQ(heard.size, 2u);
  EXPECT_EQ(heard.data[1], 5);
}

TEST(SimProtocol, DatagramsOfAnotherSizeThanTheySayAreRefused) {
  Sample<msg::Datagram> sent;
  sent.ready = Time{5000};
  sent.value.size = 3;
  auto payload = payload_of(sent);
  payload[12] = std::byte{4};
  EXPECT_EQ(refusal<Sample<msg::Datagram>>(Type::datagram, payload, Time{4000}),
            "Datagram does not have the size that it says");
  payload.resize(kDatagramHeadBytes);
  EXPECT_EQ(refusal<Sample<msg::Datagram>>(Type::datagram, payload, Time{4000}), "Datagram is cut off");
  EXPECT_EQ(refusal<Transmission>(Type::transmit, std::vector<std::byte>(1201)), "Transmit is empty or too long");
  EXPECT_EQ(refusal<Transmission>(Type::transmit, {}), "Transmit is empty or too long");
}

}  // namespace
}  // namespace sinew::sim_hil::protocol_test
