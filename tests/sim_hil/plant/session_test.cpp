// The plant behind the protocol, with a scripted runtime at the other end of a socket pair.
#include "sim_hil/plant/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <thread>

#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "math/hash.hpp"
#include "robots/quad/world/quad_world.hpp"
#include "robots/robot_kind.hpp"
#include "sim_hil/board/side_line.hpp"
#include "sim_hil/message_io.hpp"

namespace sinew::plant::session_test {
namespace {

using hal::Time;
using sim_hil::Type;

constexpr std::uint16_t kCamera = 3, kMotors = 4;  // places in the Welcome

/// The plant's messages, and the hash of all of them.
struct Received {
  sim_hil::Welcome welcome;
  int imu = 0, range = 0, baro = 0, battery = 0, frames = 0, reports = 0;
  msg::BatterySample last_battery;
  bool imu_in_order = true, ready_by_grant = true;
  Time last_imu{-1};
  std::vector<sim_hil::Truth> truth;
  std::string last_report, bye;
  math::Hash64 hash;    // of everything but reports and pixels
  math::Hash64 pixels;  // wherever they came from
};

using Command = std::optional<std::array<double, kRotors>>;

/// A runtime that answers every grant with the result of `command`, without devices, executors or modules.
class ScriptedRuntime {
 public:
  ScriptedRuntime(std::unique_ptr<hal::Stream> stream, sim_hil::Hello hello)
      : stream_(std::move(stream)), reader_(sim_hil::Sender::plant), writer_(1 << 17), hello_(std::move(hello)) {}

  /// Until plant time `end`, then hangs up without a word.
  void run_until_lost(Time end) {
    good_bye_ = false;
    run(end, hal::Duration{1}, [](Time) { return Command{}; });
    stream_.reset();
  }
  /// Until plant time `end`; `command(t)` may be none.
  void run(Time end, hal::Duration lease, const std::function<Command(Time)>& command) {
    EXPECT_TRUE(writer_.add(Type::hello, 0, Time{}, hello_));
    flush();
    sim_hil::Message m;
    while (next(m)) {
      take(m);
      if (m.header.type == Type::welcome) {
        EXPECT_TRUE(writer_.add(Type::start, 0, Time{}));
        flush();
      }
      if (m.header.type == Type::bye) return;
      const bool lockstep = hello_.mode == sim_hil::Mode::lockstep;
      if (m.header.type != (lockstep ? Type::grant : Type::imu)) continue;
      const Time t = m.header.time;
      if (const Command c = command(t)) send(*c, t, lease);
      const bool over = t >= end;
      EXPECT_TRUE(!lockstep || writer_.add(Type::done, 0, t));
      EXPECT_TRUE(!over || !good_bye_ || writer_.add_text(Type::bye, t, "script is over"));
      flush();
      if (over) return;
    }
  }
  Received got;

 private:
  void send(const std::array<double, kRotors>& values, Time commit, hal::Duration lease) {
    sim_hil::Command c;
    c.lease = lease;
    c.setpoints.armed = 1;
    c.setpoints.count = kRotors;
    std::copy(values.begin(), values.end(), c.setpoints.value.begin());
    EXPECT_TRUE(writer_.add(Type::command, kMotors, commit, c));
  }
  void flush() {
    EXPECT_TRUE(stream_->write(writer_.pending()));
    writer_.clear();
  }
  bool next(sim_hil::Message& m) {
    for (;;) {
      auto have = reader_.next(m);
      EXPECT_TRUE(have);
      if (!have) return false;
      if (*have) return true;
      auto n = stream_->read(reader_.space());
      if (!n) return false;
      reader_.filled(*n);
    }
  }
  void take_pixels(std::size_t bytes) {
    std::vector<std::uint8_t> pixels(bytes);
    std::size_t have = reader_.take_bulk(pixels);
    while (have < bytes) {
      auto n = stream_->read(std::as_writable_bytes(std::span(pixels).subspan(have)));
      ASSERT_TRUE(n);
      reader_.bulk_filled(*n);
      have += *n;
    }
    got.pixels.add(pixels.data(), pixels.size());
  }
  void take_slot(const sim_hil::FrameInfo& f) {
    const sim_hil::DeviceInfo& d = got.welcome.devices.at(kCamera);
    const std::byte* slot = memory_->data() + d.slots_offset + std::size_t{f.slot} * d.slot_bytes;
    std::uint32_t generation = 0;
    std::memcpy(&generation, slot, sizeof generation);
    EXPECT_EQ(generation, f.generation);
    got.pixels.add(slot + sim_hil::kSlotHeaderBytes, d.frame_bytes());
  }
  void take_frame(const sim_hil::Message& m) {
    sim_hil::FrameInfo f;
    ASSERT_TRUE(decode(m.header, m.payload, f));
    ++got.frames;
    EXPECT_GE(f.number, static_cast<std::uint32_t>(got.frames)) << "more than it has taken";
    EXPECT_EQ(m.header.time.ns, camera_stamp_ns(f.number));
    if (m.bulk_bytes > 0)
      take_pixels(m.bulk_bytes);
    else
      take_slot(f);
  }
  void take_welcome(const sim_hil::Message& m) {
    EXPECT_TRUE(decode(m.header, m.payload, got.welcome));
    if (got.welcome.shared_bytes == 0) return;
    auto memory = stream_->take_memory(hal::Stream::MemoryAccess::mapped);
    ASSERT_TRUE(memory);
    memory_ = std::move(*memory);
  }
  void take(const sim_hil::Message& m) {
    const std::int64_t word[] = {static_cast<std::int64_t>(m.header.type), m.header.time.ns};
    got.hash.add(word, sizeof word);
    if (m.header.type >= Type::imu && m.header.type <= Type::battery && m.header.type != Type::frame)
      got.hash.add(m.payload.data(), m.payload.size());
    switch (m.header.type) {
      case Type::welcome:
        take_welcome(m);
        break;
      case Type::imu:
        ++got.imu;
        got.imu_in_order &= m.header.time > got.last_imu;
        got.last_imu = m.header.time;
        break;
      case Type::range:
        ++got.range;
        break;
      case Type::baro:
        ++got.baro;
        break;
      case Type::battery: {
        sim_hil::Sample<msg::BatterySample> s;
        EXPECT_TRUE(decode(m.header, m.payload, s));
        got.last_battery = s.value;
        ++got.battery;
        break;
      }
      case Type::frame:
        take_frame(m);
        break;
      case Type::truth:
        EXPECT_TRUE(decode(m.header, m.payload, got.truth.emplace_back()));
        break;
      case Type::report:
        ++got.reports;
        got.last_report = sim_hil::decode_text(m.payload);
        break;
      case Type::bye:
        got.bye = sim_hil::decode_text(m.payload);
        break;
      default:
        break;
    }
  }

  std::unique_ptr<hal::Stream> stream_;
  sim_hil::MessageReceiver reader_;
  sim_hil::MessageWriter writer_;
  sim_hil::Hello hello_;
  std::unique_ptr<hal::SharedMemory> memory_;
  bool good_bye_ = true;
};

std::shared_ptr<const WorldType> quad() {
  static const auto all = robots::all_worlds();
  for (const auto& type : all)
    if (std::string_view(type->info.name) == "quad") return type;
  return nullptr;
}

SessionOptions in_quad_world() {
  SessionOptions options;
  options.world.type = quad();
  return options;
}

class PlantSession : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string why;
    auto made = CameraFeed::start(hal::system_os(), {.room_xml = quad()->room_xml, .turned_rad = {}}, why);
    ASSERT_TRUE(made) << why;
    feed_ = std::move(*made);
  }
  static void TearDownTestSuite() { feed_.reset(); }

  /// Flies the script against a plant on a thread of its own.
  Received fly(const sim_hil::Hello& hello, double seconds, hal::Duration lease,
               const std::function<Command(Time)>& command) {
    auto pair = hal::stream_pair();
    EXPECT_TRUE(pair);
    Session session(hal::system_os(), {feed_.get()}, options_);
    std::thread plant([&] { served_ = session.serve(std::move(pair->first)); });
    ScriptedRuntime runtime(std::move(pair->second), hello);
    runtime.run(Time{static_cast<std::int64_t>(seconds * 1e9)}, lease, command);
    plant.join();
    report_ = session.report();
    return std::move(runtime.got);
  }
  static sim_hil::Hello lockstep(std::uint64_t seed = 3) {
    sim_hil::Hello h;
    h.seed = seed;
    h.robot = "script";
    return h;
  }

  SessionOptions options_ = in_quad_world();
  hal::Status served_;
  SessionReport report_;
  static std::unique_ptr<CameraFeed> feed_;
};

std::unique_ptr<CameraFeed> PlantSession::feed_;

constexpr hal::Duration kLease = std::chrono::milliseconds(20);
const auto kNothing = [](Time) { return Command{}; };
const auto kClimb = [](Time) { return Command{{0.62, 0.62, 0.62, 0.62}}; };

TEST_F(PlantSession, WelcomeNamesTheDevicesAndTheSeed) {
  const Received got = fly(lockstep(77), 0.01, kLease, kNothing);
  ASSERT_TRUE(served_);
  EXPECT_EQ(got.welcome.seed, 77u);
  EXPECT_EQ(got.welcome.step.count(), kStepNs);
  ASSERT_EQ(got.welcome.devices.size(), 7u);
  EXPECT_EQ(got.welcome.devices[6].kind, sim_hil::DeviceKind::radio);
  EXPECT_EQ(got.welcome.devices[0].name, "imu");
  EXPECT_EQ(got.welcome.devices[kCamera].name, "camera");
  EXPECT_EQ(got.welcome.devices[kCamera].width, 320u);
  EXPECT_EQ(got.welcome.devices[kCamera].format, msg::PixelFormat::yuyv);
  EXPECT_EQ(got.welcome.devices[kMotors].name, "motors");
  EXPECT_EQ(got.welcome.devices[kMotors].channels, 4u);
  EXPECT_EQ(got.welcome.devices[5].kind, sim_hil::DeviceKind::battery);
  EXPECT_EQ(report_.reason, "script is over");
  EXPECT_FALSE(report_.broken);
}

TEST_F(PlantSession, ASeedOfItsOwnOverridesTheRuntimes) {
  options_.seed = 5;
  EXPECT_EQ(fly(lockstep(77), 0.01, kLease, kNothing).welcome.seed, 5u);
  EXPECT_EQ(report_.seed, 5u);
}

TEST_F(PlantSession, LockstepDeliversEverySampleInOrder) {
  const Received got = fly(lockstep(), 1.0, kLease, kNothing);
  EXPECT_EQ(got.imu, 1000);
  EXPECT_EQ(got.range, 100);
  EXPECT_EQ(got.baro, 50);
  EXPECT_EQ(got.battery, 10);
  EXPECT_NEAR(got.last_battery.voltage_v, got.truth.back().battery_v, 0.5);
  EXPECT_EQ(got.frames, 29);  // 30 exposed, the last is still on its way
  EXPECT_EQ(got.truth.size(), 100u);
  EXPECT_GE(got.reports, 2);
  EXPECT_TRUE(got.imu_in_order);
  EXPECT_EQ(report_.render_late, 0u);
}

std::vector<Fault> faults(std::initializer_list<const char*> texts) {
  std::vector<Fault> all;
  std::string why;
  for (const char* text : texts)
    if (auto f = parse_fault(text, why)) all.push_back(*f);
  EXPECT_EQ(all.size(), texts.size()) << why;
  return all;
}

TEST_F(PlantSession, FaultsTakeAwayWhatTheySayAndTheReportNamesThem) {
  options_.faults = faults({"imu:off@0.5", "baro:slow(5)@0", "battery:duplicated@0", "range:stuck@7"});
  const Received got = fly(lockstep(), 1.0, kLease, kNothing);
  EXPECT_EQ(got.imu, 500);
  EXPECT_EQ(got.range, 100);
  EXPECT_EQ(got.baro, 10);
  EXPECT_EQ(got.battery, 20);
  EXPECT_THAT(got.last_report,
              testing::HasSubstr(R"({"fault":"imu:off@0.5","device":"imu","kind":"off","from_s":0.5,)"));
  EXPECT_THAT(got.last_report, testing::HasSubstr(R"("kind":"slow","from_s":0,"affected":40,"first_s":0.04})"));
  EXPECT_THAT(got.last_report, testing::Not(testing::HasSubstr("range:stuck"))) << "its time has not come";
}

TEST_F(PlantSession, SameFaultsAndSeedGiveTheSameBytesOnTheWire) {
  options_.faults = faults({"imu:garbage@0.1+0.05", "range:delayed(30ms)@0.1", "camera:garbage@0.2..0.3",
                            "camera:delayed(80ms)@0.3..0.5", "link:intermittent(20ms)@0.5"});
  const auto flight = [&](std::uint64_t seed) {
    const Received got = fly(lockstep(seed), 0.7, kLease, kClimb);
    return std::pair(got.hash.value(), got.pixels.value());
  };
  const auto first = flight(9), again = flight(9);
  EXPECT_EQ(first, again);
  options_.faults.clear();
  EXPECT_NE(flight(9), first);
}

TEST_F(PlantSession, ClosedConnectionLeavesAVehicleWhoseMotorsStopWithTheLease) {
  options_.faults = faults({"link:closed@1"});
  const Received got = fly(lockstep(), 5.0, kLease, kClimb);
  EXPECT_EQ(got.bye, "") << "a connection that breaks says nothing";
  EXPECT_EQ(got.imu, 1000);
  EXPECT_EQ(report_.reason, "a fault closed the connection");
  EXPECT_EQ(report_.stale_actuations, 0u);
  EXPECT_THAT(report_.text, testing::HasSubstr(R"("flew":true)"));
  EXPECT_TRUE(report_.still);
}

TEST_F(PlantSession, SameSeedAndCommandsGiveTheSameBytesOnTheWire) {
  const auto flight = [&](std::uint64_t seed) {
    const Received got = fly(lockstep(seed), 0.7, kLease, kClimb);
    return std::pair(got.hash.value(), got.pixels.value());
  };
  const auto first = flight(9), again = flight(9), other = flight(10);
  EXPECT_EQ(first, again);
  EXPECT_NE(first.first, other.first);
  EXPECT_NE(first.second, other.second);
}

TEST_F(PlantSession, FramesInSharedMemoryAreTheFramesOfTheStream) {
  sim_hil::Hello hello = lockstep();
  const Received stream = fly(hello, 0.5, kLease, kClimb);
  hello.accepts_shared_memory = true;
  const Received shared = fly(hello, 0.5, kLease, kClimb);
  EXPECT_EQ(stream.welcome.shared_bytes, 0u);
  EXPECT_GT(shared.welcome.shared_bytes, 8u * 320 * 240 * 2);
  EXPECT_EQ(stream.frames, 14);
  EXPECT_EQ(shared.frames, 14);
  EXPECT_EQ(stream.pixels.value(), shared.pixels.value());
  EXPECT_EQ(stream.hash.value(), shared.hash.value());
}

TEST_F(PlantSession, MotorsStopWhenTheLeaseIsOver) {
  options_.world.values["spread"] = 0;
  options_.world.values["gust_mps"] = 0;
  const auto once = [](Time t) { return t.ns == 0 ? kClimb(t) : Command{}; };
  const Received got = fly(lockstep(), 0.9, std::chrono::milliseconds(400), once);
  EXPECT_EQ(report_.lease_expiries, 1u);
  ASSERT_GE(got.truth.size(), 65u);
  const double v_at_expiry = got.truth[40].v_world_mps.z;  // 100 Hz: 0.4 s
  EXPECT_GT(v_at_expiry, 0.3);
  // 0.2 s later the rotors have run down and gravity has taken most of its share.
  EXPECT_LT(got.truth[60].v_world_mps.z, v_at_expiry - 0.15 * kGravity);
}

/// A plant behind a listener, on a socket of its own.
class DoorPlant {
 public:
  DoorPlant(CameraFeed& feed, const SessionOptions& options) : session(hal::system_os(), {&feed}, options) {
    EXPECT_NE(mkdtemp(folder_.data()), nullptr);
    auto listener = hal::listen_stream("unix:" + folder_ + "/plant.sock");
    EXPECT_TRUE(listener);
    endpoint_ = (*listener)->endpoint();
    plant_listener_ = std::move(*sim_hil::PlantListener::open(
        hal::system_os(), std::move(*listener), Session::description({}, options), {"listener", 0, {}, 1 << 18}));
    thread_ = std::thread([this] {
      auto caller = plant_listener_->wait_runtime(kPatience);
      if (caller) {
        std::vector<sim_hil::Caller> callers;
        callers.push_back(std::move(*caller));
        served = session.serve(std::move(callers), *plant_listener_);
      }
    });
  }
  ~DoorPlant() {
    wait();
    std::filesystem::remove_all(folder_);
  }
  void wait() {
    if (thread_.joinable()) thread_.join();
  }
  std::unique_ptr<hal::Stream> connect() { return std::move(*hal::connect_stream(endpoint_, kPatience)); }
  static constexpr hal::Duration kPatience = std::chrono::seconds(20);
  Session session;
  hal::Status served;

 private:
  std::string folder_ = (std::filesystem::temp_directory_path() / "sinew_session_XXXXXX").string();
  std::string endpoint_;
  std::unique_ptr<sim_hil::PlantListener> plant_listener_;
  std::thread thread_;
};

sim_hil::Hello free_running(double rate = 1) {
  sim_hil::Hello h;
  h.mode = sim_hil::Mode::free_running;
  h.robot = "script";
  h.rate = rate;
  return h;
}

TEST_F(PlantSession, WorldGoesOnWhenTheRuntimeIsLostAndAnotherTakesOver) {
  options_.relink_s = 20;
  DoorPlant plant(*feed_, options_);
  Time last{};
  {
    ScriptedRuntime first(plant.connect(), free_running());
    first.run_until_lost(Time{50'000'000});  // hangs up without a word
    last = first.got.last_imu;
    EXPECT_GE(last, Time{50'000'000});
  }
  // Turned away until the plant has noticed; then a caller is served.
  Received got;
  while (got.imu == 0) {
    ScriptedRuntime second(plant.connect(), free_running());
    second.run(Time{last.ns + 1'000'000'000}, kLease, kNothing);
    got = std::move(second.got);
  }
  plant.wait();
  EXPECT_GT(got.truth.at(0).p_world_m.z, 0);
  EXPECT_GT(got.last_imu, last) << "plant time has gone on, not begun anew";
  EXPECT_EQ(plant.session.report().relinks, 1u);
  EXPECT_FALSE(plant.session.report().broken) << plant.session.report().reason;
  EXPECT_EQ(plant.session.report().reason, "script is over");
}

TEST_F(PlantSession, RuntimeOfAnotherPaceIsTurnedAwayAndTheWorldEndsWhenNobodyElseComes) {
  options_.relink_s = 0.5;
  DoorPlant plant(*feed_, options_);
  ScriptedRuntime(plant.connect(), free_running()).run_until_lost(Time{20'000'000});
  ScriptedRuntime other(plant.connect(), free_running(0.5));
  other.run(Time{1'000'000'000}, kLease, kNothing);
  EXPECT_EQ(other.got.imu, 0);
  plant.wait();
  EXPECT_TRUE(plant.session.report().broken);
  EXPECT_NE(plant.session.report().reason.find("no other runtime has come"), std::string::npos);
}

TEST_F(PlantSession, InLockstepALostRuntimeIsTheEnd) {
  options_.relink_s = 3600;
  DoorPlant plant(*feed_, options_);
  ScriptedRuntime(plant.connect(), lockstep()).run_until_lost(Time{20'000'000});
  plant.wait();
  EXPECT_TRUE(plant.session.report().broken);
  EXPECT_EQ(plant.session.report().relinks, 0u);
}

TEST_F(PlantSession, StopLineStopsTheMotorsThoughTheRuntimeGoesOnCommanding) {
  options_.world.values["spread"] = 0;
  options_.world.values["gust_mps"] = 0;
  DoorPlant plant(*feed_, options_);
  std::string why;
  auto line = sim_hil::SideLine::open(plant.connect(), "parent", DoorPlant::kPatience, why);
  ASSERT_TRUE(line) << why;
  ScriptedRuntime runtime(plant.connect(), lockstep());
  constexpr std::int64_t kPullNs = 400'000'000;
  bool pulled = false;
  runtime.run(Time{900'000'000}, std::chrono::seconds(1), [&](Time t) {
    if (t.ns >= kPullNs && !pulled) pulled = static_cast<bool>((*line)->stop());
    return kClimb(t);
  });
  plant.wait();
  const SessionReport& report = plant.session.report();
  EXPECT_TRUE(report.stopped_by_supervisor);
  EXPECT_NEAR(static_cast<double>(report.stopped_at.ns), kPullNs, 2'000'000);
  EXPECT_NE(report.text.find("\"stopped_by_supervisor\":true"), std::string::npos);
  const auto& truth = runtime.got.truth;
  ASSERT_GE(truth.size(), 65u);
  EXPECT_GT(truth[40].v_world_mps.z, 0.3);
  EXPECT_LT(truth[60].v_world_mps.z, truth[40].v_world_mps.z - 0.15 * kGravity);
}

TEST_F(PlantSession, MotorsStayOffWithoutACommand) {
  const Received got = fly(lockstep(), 0.5, kLease, kNothing);
  for (const sim_hil::Truth& t : got.truth) EXPECT_NEAR(t.p_world_m.z, kFeetBelowBase, 0.003);
  EXPECT_EQ(got.truth.back().contact, 1u);
  EXPECT_EQ(got.truth.back().landed, 1u);
}

TEST_F(PlantSession, CommandsActFromTheStepOfTheirCommit) {
  options_.world.values["spread"] = 0;
  options_.world.values["gust_mps"] = 0;
  options_.world.values["sensor_errors"] = 0;
  const auto at = [&](std::int64_t commit_ns) {
    const auto late = [=](Time t) { return t.ns >= commit_ns ? kClimb(t) : Command{}; };
    return fly(lockstep(), 0.5, kLease, late).truth.back().p_world_m.z;
  };
  EXPECT_GT(at(0), at(50'000'000) + 0.01);
}

TEST_F(PlantSession, EndsItselfWhenTheDurationIsOver) {
  options_.duration_s = 0.2;
  const Received got = fly(lockstep(), 5.0, kLease, kNothing);
  EXPECT_TRUE(served_);
  EXPECT_EQ(got.bye, "duration is over");
  EXPECT_EQ(got.imu, 200);
}

TEST_F(PlantSession, RefusesTheModeThatItWasNotStartedFor) {
  options_.only = sim_hil::Mode::free_running;
  const Received got = fly(lockstep(), 1.0, kLease, kNothing);
  EXPECT_FALSE(served_);
  EXPECT_EQ(got.bye, "this plant was started for free-running only");
}

TEST_F(PlantSession, ALostConnectionIsNotAGoodEnd) {
  auto pair = hal::stream_pair();
  ASSERT_TRUE(pair);
  Session session(hal::system_os(), {feed_.get()}, options_);
  std::thread plant([&] { served_ = session.serve(std::move(pair->first)); });
  pair->second.reset();
  plant.join();
  EXPECT_FALSE(served_);
  EXPECT_TRUE(session.report().broken);
  EXPECT_FALSE(session.report().reason.empty());
}

TEST_F(PlantSession, FreeRunningDeliversEverySampleAndMeasuresTheGap) {
  sim_hil::Hello hello = lockstep();
  hello.mode = sim_hil::Mode::free_running;
  hello.rate = 0.5;
  const Received got = fly(hello, 0.5, kLease, kNothing);
  ASSERT_TRUE(served_);
  EXPECT_GE(got.imu, 500);  // none is lost, however late this machine is
  EXPECT_TRUE(got.imu_in_order);
  EXPECT_GT(report_.imu_gap_max_ns, 1'900'000);  // at half the rate 2 ms apart
  EXPECT_NE(got.last_report.find("\"imu_gap_max_ns\":"), std::string::npos);
}

// ---- several robots

/// Two scripted runtimes against one plant, on a thread each.
class SessionOfTwo : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (auto& feed : feeds_) {
      std::string why;
      auto made =
          CameraFeed::start(hal::system_os(), {.room_xml = quad()->room_xml, .robots = 2, .turned_rad = {}}, why);
      ASSERT_TRUE(made) << why;
      feed = std::move(*made);
    }
  }
  static void TearDownTestSuite() { feeds_ = {}; }

  struct Script {
    bool slow = false;         // the first runtime answers each grant late
    double second_s = 0.3;     // when the second one leaves
    bool second_lost = false;  // without a word
  };
  struct Result {
    Received ant, bee;
    SessionReport ant_report, bee_report;
  };

  Result run(const Script& script) {
    auto first = hal::stream_pair(), second = hal::stream_pair();
    Session session(hal::system_os(), {feeds_[0].get(), feeds_[1].get()}, options_);
    std::thread plant([&] {
      std::string why;
      std::vector<sim_hil::Caller> callers(2);
      callers[0].stream = std::move(first->first), callers[1].stream = std::move(second->first);
      for (auto& caller : callers) EXPECT_TRUE(hear_hello(caller, "test", why)) << why;
      EXPECT_TRUE(session.serve(std::move(callers)));
    });
    ScriptedRuntime ant(std::move(first->second), lockstep_of("ant")),
        bee(std::move(second->second), lockstep_of("bee"));
    std::thread other([&] {
      const Time end{static_cast<std::int64_t>(script.second_s * 1e9)};
      if (script.second_lost)
        bee.run_until_lost(end);
      else
        bee.run(end, kLease, [](Time) { return Command{{0.58, 0.58, 0.58, 0.58}}; });
    });
    ant.run(Time{300'000'000}, kLease, [&](Time) {
      if (script.slow) std::this_thread::sleep_for(std::chrono::microseconds(300));
      return Command{{0.62, 0.62, 0.62, 0.62}};
    });
    other.join();
    plant.join();
    return {std::move(ant.got), std::move(bee.got), session.report(0), session.report(1)};
  }
  static sim_hil::Hello lockstep_of(const char* robot) {
    sim_hil::Hello hello;
    hello.robot = robot;
    return hello;
  }
  static SessionOptions two_quads() {
    SessionOptions options = in_quad_world();
    // Clocks without offset and drift: the scripts end by plant time.
    options.world.robots = {{"ant", {{"start_x_m", -0.8}, {"clock_offset_s", 0}, {"clock_drift_ppm", 0}}},
                            {"bee", {{"start_x_m", 0.8}, {"clock_offset_s", 0}, {"clock_drift_ppm", 0}}}};
    options.seed = 5;
    return options;
  }

  SessionOptions options_ = two_quads();
  static std::array<std::unique_ptr<CameraFeed>, 2> feeds_;
};

std::array<std::unique_ptr<CameraFeed>, 2> SessionOfTwo::feeds_;

TEST_F(SessionOfTwo, GivesTheSameBytesWhicheverRuntimeIsTheSlowerOne) {
  const Result quick = run({}), slow = run({.slow = true});
  EXPECT_EQ(quick.ant.hash.value(), slow.ant.hash.value());
  EXPECT_EQ(quick.bee.hash.value(), slow.bee.hash.value());
  EXPECT_EQ(quick.bee.pixels.value(), slow.bee.pixels.value());
  EXPECT_NE(quick.ant.hash.value(), quick.bee.hash.value());
  EXPECT_EQ(quick.ant.imu, 300);
  EXPECT_NEAR(quick.ant.truth.front().p_world_m.x, -0.8, 0.01);
  EXPECT_NEAR(quick.bee.truth.front().p_world_m.x, 0.8, 0.01);
  EXPECT_NE(quick.bee.last_report.find("\"robot\":\"bee\""), std::string::npos);
}

TEST_F(SessionOfTwo, OneThatLeavesOrIsLostLetsTheOtherGoOn) {
  for (const bool lost : {false, true}) {
    const Result result = run({.second_s = 0.1, .second_lost = lost});
    EXPECT_EQ(result.ant.imu, 300);
    EXPECT_EQ(result.ant_report.reason, "script is over");
    EXPECT_FALSE(result.ant_report.broken);
    EXPECT_EQ(result.bee_report.broken, lost);
    EXPECT_EQ(result.bee_report.stale_actuations, 0u) << "its motors stop with the lease of its last command";
  }
}

TEST_F(SessionOfTwo, RobotsClocksBeginDifferently) {
  options_.world.robots[0].values["clock_offset_s"] = 2;
  const Result result = run({});
  EXPECT_EQ(result.ant.imu, 0) << "its clock is beyond the script's end with the first grant";
  EXPECT_EQ(result.bee.imu, 300);
}

TEST(Worlds, AreWhatTheRobotsFoldersSayAndCanBeMade) {
  const auto worlds = robots::all_worlds();
  ASSERT_GE(worlds.size(), 2u);
  for (const auto& type : worlds) {
    const WorldInfo* said = robots::find_world(type->info.name);
    ASSERT_NE(said, nullptr) << type->info.name << ": describe_" << type->info.name << "() has no world";
    EXPECT_EQ(said->devices.data(), type->info.devices.data()) << "one list, for whoever reads a robot file too";
    ASSERT_NE(type->info.find(Part::actuators), nullptr);
    EXPECT_TRUE(type->info.has(type->info.find(Part::actuators)->fault));
    EXPECT_TRUE(type->info.has(FaultDevice::link));
    EXPECT_EQ(type->room_xml.empty() && !type->painter, type->info.find(Part::camera) == nullptr);
    auto world = WorldChoice{.type = type}.create(1);
    if (type->info.has_bodies) {
      EXPECT_EQ(world.error().code, hal::Errc::bad_argument) << "without a body";
      continue;
    }
    ASSERT_TRUE(world);
    EXPECT_EQ((*world)->robot(0).joints() != nullptr, type->info.find(Part::joints) != nullptr);
    EXPECT_FALSE((*world)->robot(0).verdict().outcome.empty());
  }
  EXPECT_EQ(robots::find_world("moon"), nullptr);
}

}  // namespace
}  // namespace sinew::plant::session_test
