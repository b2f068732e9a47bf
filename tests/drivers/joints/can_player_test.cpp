#include "drivers/joints/can_player.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "hal/can_waiting.hpp"
#include "hal/linux/can/can.hpp"
#include "qemu_user.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "wire/candump.hpp"

namespace sinew::drivers::can_player_test {
namespace {

using namespace std::chrono_literals;
using hal::Time;

// A CANopen drive that starts, and a DroneCAN ESC, on two buses.
constexpr std::string_view kLog =
    "(1700000000.000000) can0 000#8104\n"
    "(1700000000.010000) can0 704#00\n"
    "(1700000000.010500) can1 0804062A#0003FDF0080010C5\n"
    "(1700000000.012000) can0 604#4018100100000000\n"
    "\n"
    "(1700000000.013000) can0 20000004#0004000000000000\n"
    "(1700000000.013250) can0 584#4318100151000000\n"
    "(1700000000.020000) can0 123#R4\n";

CanPlayer opened(std::string_view log, const CanPlayer::Options& options = {}) {
  std::string why;
  auto player = CanPlayer::open(log, options, why);
  EXPECT_TRUE(player) << why;
  return player ? std::move(*player) : CanPlayer{};
}

std::string refused(std::string_view log, const CanPlayer::Options& options = {}) {
  std::string why;
  EXPECT_FALSE(CanPlayer::open(log, options, why));
  return why;
}

TEST(CanPlayer, LogComesBackAsItWasTimesIncluded) {
  hal::ManualClock clock;
  sim_hil::MemoryCan wire(1'000'000, &clock);
  auto &bus = wire.attach(), &ear = wire.attach();
  CanPlayer player = opened(kLog, {.speed = 1, .interface = "can0"});
  EXPECT_EQ(player.frames(), 5u);
  constexpr std::int64_t kStart = 1'700'000'000'000'000'000;  // so that the stamps are those of the log
  for (Time now{kStart}; now != hal::kNever; now = player.step(now, bus)) clock.set(now);
  std::string log;
  msg::CanFrame frame;
  for (auto got = ear.read(frame); got && *got; got = ear.read(frame)) {
    std::string line(wire::kCandumpMax, ' ');
    line.resize(wire::candump_format(frame, "can0", line));
    log += line + "\n";
  }
  EXPECT_EQ(log,
            "(1700000000.000000) can0 000#8104\n"
            "(1700000000.010000) can0 704#00\n"
            "(1700000000.012000) can0 604#4018100100000000\n"
            "(1700000000.013250) can0 584#4318100151000000\n"
            "(1700000000.020000) can0 123#R4\n");
  EXPECT_EQ(player.stats().sent, 5u);
  EXPECT_EQ(player.stats().error_frames, 1u);
}

TEST(CanPlayer, TwiceTheSpeedTakesHalfTheTime) {
  sim_hil::MemoryCan wire;
  auto& bus = wire.attach();
  CanPlayer player = opened(kLog, {.speed = 2, .interface = {}});
  EXPECT_EQ(player.step(Time{0}, bus), Time{5'000'000});
  EXPECT_EQ(player.step(Time{5'000'000}, bus), Time{5'250'000});
  EXPECT_EQ(player.step(Time{9'999'999}, bus), Time{10'000'000});
  EXPECT_EQ(player.step(Time{10'000'000}, bus), hal::kNever);
}

TEST(CanPlayer, BusThatIsGoneIsWaitedFor) {
  sim_hil::MemoryCan wire;
  auto &bus = wire.attach(), &ear = wire.attach();
  CanPlayer player = opened(kLog, {.speed = 0, .interface = {}});
  wire.connect(false);
  EXPECT_EQ(player.step(Time{0}, bus), Time{1'000'000});
  EXPECT_EQ(player.stats().sent, 0u);
  wire.connect(true);
  EXPECT_EQ(player.step(Time{1'000'000}, bus), hal::kNever);
  EXPECT_EQ(player.stats().sent, 6u);
  msg::CanFrame frame;
  int received = 0;
  while (true) {
    const auto got = ear.read(frame);
    if (got && !*got) break;
    received += got ? 1 : 0;
  }
  EXPECT_EQ(received, 6);
}

TEST(CanPlayer, LogReachesAnotherProgramsSocket) {
  SINEW_SKIP_UNDER_QEMU_USER("IP_MULTICAST_ALL");
  const auto watch = hal::start_watch();
  hal::CanSpec spec;
  spec.transport = "udp", spec.address = std::to_string(getpid() % 255 + 1);
  std::string why;
  auto bus = hal::open_can(spec, hal::system_os(), watch, why), ear = hal::open_can(spec, hal::system_os(), watch, why);
  ASSERT_TRUE(bus && ear) << why;
  CanPlayer player = opened(kLog);
  for (Time next = hal::system_os().now(); next != hal::kNever; next = player.step(hal::system_os().now(), **bus))
    hal::system_os().sleep_until(next);
  EXPECT_EQ(player.stats().sent, 5u);
  EXPECT_EQ(player.stats().refused, 1u) << "UDP has no remote frames";
  std::vector<std::uint32_t> ids;
  msg::CanFrame frame;
  while (ids.size() < 5) {
    ASSERT_TRUE(hal::next_frame(**ear, frame));
    ids.push_back(frame.id);
  }
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x000, 0x704, 0x0804062A, 0x604, 0x584}));
}

TEST(CanPlayer, WrongLogsSayWhereAndWhat) {
  EXPECT_EQ(refused("(1.0) can0 123#\n\n(1.0) can0 12#\n"), "line 3: identifier: three or eight hex digits");
  EXPECT_EQ(refused(""), "no frame is in the log");
  EXPECT_EQ(refused(kLog, {.speed = 1, .interface = "can7"}), "no frame of can7 is in the log");
  EXPECT_EQ(refused(kLog, {.speed = -1, .interface = {}}), "speed: 0 to a million");
}

}  // namespace
}  // namespace sinew::drivers::can_player_test
