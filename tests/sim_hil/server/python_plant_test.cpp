// plant.py is the protocol's second implementation, written from docs/sim-protocol.md. A small controller in here lifts
// its mass to one metre through the board, in lockstep, and every byte that is seen must be the same in every run.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>

#include "hal/linux/socket.hpp"
#include "sim_hil/board/sim_board.hpp"
#include "source_dir.hpp"

namespace sinew::sim_hil::python_plant_test {
namespace {

using namespace std::chrono_literals;

/// The Python plant as a child process.
class PythonPlant {
 public:
  explicit PythonPlant(const std::string& kind) {
    const std::string path = testing::TempDir() + "plant_" + std::to_string(::getpid());
    std::remove(path.c_str());
    const std::string listen = kind == "unix" ? "unix:" + path : "tcp:0";
    process_ =
        ::popen(("python3 " + test::source_dir() + "/tests/sim_hil/server/plant.py " + listen + " 4").c_str(), "r");
    std::array<char, 512> line{};
    if (process_ && std::fgets(line.data(), line.size(), process_)) {
      std::string where(line.data(), std::strcspn(line.data(), "\n"));
      endpoint = kind == "unix" ? "unix:" + where : "tcp:127.0.0.1:" + where;
    }
  }
  ~PythonPlant() { finish(); }
  int finish() {
    const int code = process_ ? ::pclose(process_) : 0;
    process_ = nullptr;
    if (endpoint.starts_with("unix:")) std::remove(endpoint.c_str() + 5);
    return code;
  }
  std::string endpoint;

 private:
  std::FILE* process_ = nullptr;
};

struct Flight {
  std::vector<std::byte> seen;  // every sample as the driver read it, and when
  std::string report, end;
  double height_m = 0;
  int exit_code = -1;
};

template <class T>
void log(std::vector<std::byte>& to, const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  to.insert(to.end(), bytes, bytes + sizeof value);
}

/// Height over thrust, 4 ms after each range sample: the smallest loop that flies.
class Lifter {
 public:
  double thrust(double height_m, double dt_s) {
    const double speed_mps = first_ ? 0.0 : (height_m - last_m_) / dt_s;
    first_ = false;
    last_m_ = height_m;
    smooth_mps_ += 0.3 * (speed_mps - smooth_mps_);
    return std::clamp((9.81 + 4.0 * (1.0 - height_m) - 4.0 * smooth_mps_) / 20.0, 0.0, 1.0);
  }

 private:
  bool first_ = true;
  double last_m_ = 0, smooth_mps_ = 0;
};

Flight fly(const std::string& kind, std::uint64_t seed) {
  Flight flight;
  PythonPlant plant(kind);
  auto stream = hal::connect_stream(plant.endpoint, 10s);
  EXPECT_TRUE(stream) << plant.endpoint;
  if (!stream) return flight;
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  options.seed = seed;
  options.on_report = [&](const std::string& json) { flight.report = json; };
  std::string why;
  auto board = SimBoard::open(std::move(*stream), options, why);
  EXPECT_TRUE(board) << why;
  if (!board) return flight;
  hal::Imu* imu = *(*board)->sensor<msg::ImuSample>("imu");
  hal::Range* range = *(*board)->sensor<msg::RangeSample>("range");
  hal::Actuators* motors = *(*board)->actuators("motors");
  Lifter lifter;
  for (auto until = (*board)->next_grant({}); until; until = (*board)->next_grant(*until)) {
    clock.set(*until);
    msg::ImuSample i;
    while (*imu->read(i)) log(flight.seen, i), log(flight.seen, *until);
    msg::RangeSample r;
    while (*range->read(r)) {
      log(flight.seen, r), log(flight.seen, *until);
      flight.height_m = r.range_m;
      msg::ActuatorCommand command;
      command.stamp = r.stamp, command.count = 4, command.armed = 1;
      command.value.fill(lifter.thrust(r.range_m, 0.02));
      EXPECT_TRUE(motors->write(command, 50ms));
    }
  }
  flight.end = (*board)->end_reason();
  board->reset();
  flight.exit_code = plant.finish();
  return flight;
}

TEST(PythonPlant, IsLiftedToOneMetreThroughTheBoard) {
  const Flight flight = fly("unix", 1);
  EXPECT_EQ(flight.end, "end of run");
  EXPECT_EQ(flight.exit_code, 0);
  EXPECT_NEAR(flight.height_m, 1.0, 0.1);
  EXPECT_NE(flight.report.find("\"valid\": true"), std::string::npos) << flight.report;
}

TEST(PythonPlant, SameSeedGivesTheSameBytesOverUnixAndTcp) {
  const Flight a = fly("unix", 7), b = fly("unix", 7), c = fly("tcp", 7);
  EXPECT_EQ(a.seen.size(), 4001 * (sizeof(msg::ImuSample) + 8) + 200 * (sizeof(msg::RangeSample) + 8));
  EXPECT_TRUE(a.seen == b.seen);
  EXPECT_TRUE(a.seen == c.seen);
  EXPECT_EQ(a.report, c.report);
}

TEST(PythonPlant, AnotherSeedGivesOtherBytes) { EXPECT_FALSE(fly("unix", 7).seen == fly("unix", 8).seen); }

TEST(PythonPlant, RefusesWhatItCannotServeInWords) {
  PythonPlant plant("unix");
  auto stream = hal::connect_stream(plant.endpoint, 10s);
  ASSERT_TRUE(stream);
  Hello free;
  free.mode = Mode::free_running;
  MessageWriter writer(4096);
  ASSERT_TRUE(writer.add(Type::hello, 0, Time{}, free));
  ASSERT_TRUE((*stream)->write(writer.pending()));
  MessageReceiver reader(Sender::plant);
  Message m;
  while (!*reader.next(m)) {
    auto n = (*stream)->read(reader.space());
    ASSERT_TRUE(n);
    reader.filled(*n);
  }
  EXPECT_EQ(m.header.type, Type::bye);
  EXPECT_EQ(decode_text(m.payload), "this plant speaks version 1, lockstep");
}

}  // namespace
}  // namespace sinew::sim_hil::python_plant_test
