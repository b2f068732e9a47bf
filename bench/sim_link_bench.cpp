// What one lockstep round trip costs: SimBoard and PlantLink (an IMU sample and a grant one way, a command and a done
// back) beside two processes that pass the same numbers of bytes and read none of them. All on one core.
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "hal/linux/socket.hpp"
#include "pairs.hpp"
#include "sim_hil/board/sim_board.hpp"
#include "sim_hil/server/plant_link.hpp"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using namespace sim_hil;

constexpr std::size_t kFromPlant = 2 * kHeaderBytes + kImuBytes, kToPlant = 2 * kHeaderBytes + kCommandBytes;
constexpr int kPairs = 25, kRoundTrips = 2000;

void pin_to_one_core() {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(0, &set);
  if (sched_setaffinity(0, sizeof set, &set) != 0) std::perror("sched_setaffinity");
}

/// Runs `peer` in a child process; returns our end of the line to it.
template <class Peer>
std::unique_ptr<hal::Stream> fork_peer(const Peer& peer, pid_t& child) {
  auto ends = hal::stream_pair();
  if (!ends) std::exit(2);
  child = ::fork();
  if (child == 0) {
    ends->first.reset();
    peer(std::move(ends->second));
    std::_Exit(0);
  }
  return std::move(ends->first);
}

void serve_plant(std::unique_ptr<hal::Stream> stream) {
  PlantDescription plant;
  plant.name = "bench";
  plant.step = 250us;
  plant.devices.resize(2);
  plant.devices[0].kind = DeviceKind::imu, plant.devices[0].name = "imu";
  plant.devices[1].kind = DeviceKind::actuators, plant.devices[1].name = "motors", plant.devices[1].channels = 4;
  std::string why;
  auto link = PlantLink::accept(std::move(stream), plant, nullptr, why);
  if (!link || !(*link)->wait_start()) return;
  msg::ImuSample sample;
  for (Time t{0};; t = t + 250us) {
    sample.stamp = t;
    if (!(*link)->send(0, sample, t) || !(*link)->grant(t)) return;
    bench::keep((*link)->setpoints_at(1, t));
  }
}

bool read_all(hal::Stream& stream, std::span<std::byte> into) {
  while (!into.empty()) {
    auto n = stream.read(into);
    if (!n) return false;
    into = into.subspan(*n);
  }
  return true;
}

void serve_bytes(std::unique_ptr<hal::Stream> stream) {
  std::array<std::byte, kToPlant> in{};
  const std::array<std::byte, kFromPlant> out{};
  while (read_all(*stream, in) && stream->write(out)) {
  }
}

int run() {
  pin_to_one_core();
  pid_t plant = 0, floor = 0;
  auto plant_line = fork_peer(serve_plant, plant);
  auto floor_line = fork_peer(serve_bytes, floor);

  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board = SimBoard::open(std::move(plant_line), options, why);
  if (!board) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return 2;
  }
  hal::Imu* imu = *(*board)->sensor<msg::ImuSample>("imu");
  hal::Actuators* motors = *(*board)->actuators("motors");
  msg::ActuatorCommand command;
  command.count = 4, command.armed = 1;
  auto until = (*board)->next_grant({});
  const auto ours = [&] {
    clock.set(*until);
    msg::ImuSample sample;
    while (*imu->read(sample)) bench::keep(sample);
    if (!motors->write(command, 10ms)) std::exit(2);
    until = (*board)->next_grant(*until);
    if (!until) std::exit(2);
  };
  const std::array<std::byte, kToPlant> out{};
  std::array<std::byte, kFromPlant> in{};
  const auto bytes = [&] {
    if (!floor_line->write(out) || !read_all(*floor_line, in)) std::exit(2);
  };
  const bench::Ratio r = bench::alternate(kPairs, kRoundTrips, ours, bytes);
  const bool good = bench::report("lockstep round trip, one core", r, 1.5);
  std::printf("%-34s %.0f round trips/s; goal at most 12 us, took %.1f us\n", "", 1e6 / r.ours_us, r.ours_us);
  board->reset();
  floor_line.reset();
  ::waitpid(plant, nullptr, 0);
  ::waitpid(floor, nullptr, 0);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew

int main() { return sinew::run(); }
