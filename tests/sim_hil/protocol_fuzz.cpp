// Both ends of the simulator protocol against a hostile peer. The first byte chooses the end (bit 0: 0 the plant reads
// the rest, 1 the runtime does), whether the stream comes in small pieces (bit 1), and whether sequence numbers and
// flags are corrected first (bit 2), so that the fuzzer gets behind the framing; bit 3: the runtime's end is a side
// line.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "memory_stream.hpp"
#include "sim_hil/board/side_line.hpp"
#include "sim_hil/board/sim_board.hpp"
#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/server/side_line_server.hpp"

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;

void repair(std::vector<std::byte>& stream) {
  std::uint32_t sequence = 0;
  for (std::size_t at = 0; at + kHeaderBytes <= stream.size(); ++sequence) {
    std::uint32_t size = 0;
    std::memcpy(&size, stream.data() + at, sizeof size);
    std::memcpy(stream.data() + at + 8, &sequence, sizeof sequence);
    std::memset(stream.data() + at + 12, 0, 4);
    at += std::max<std::size_t>(size, kHeaderBytes);
  }
}

void hear_as_plant(std::unique_ptr<hal::Stream> stream) {
  PlantDescription plant;
  plant.name = "fuzz";
  plant.step = 1ms;
  plant.devices.resize(3);
  plant.devices[0].kind = DeviceKind::imu, plant.devices[0].name = "imu";
  plant.devices[1].kind = DeviceKind::actuators, plant.devices[1].name = "motors", plant.devices[1].channels = 4;
  plant.devices[2].kind = DeviceKind::radio, plant.devices[2].name = "radio";
  std::string why;
  Caller caller;
  caller.stream = std::move(stream);
  if (!hear_hello(caller, plant.name, why)) return;
  if (caller.hello.mode == Mode::side_line) {
    const hal::ManualClock host;
    std::atomic<bool> stopped{false};
    return serve_side_line(caller, {host, plant, stopped});
  }
  auto link = PlantLink::accept(std::move(caller), plant, nullptr, why);
  if (!link || !(*link)->wait_start()) return;
  for (Time t{0}; (*link)->grant(t); t = t + 1ms) {
    const Setpoints s = (*link)->setpoints_at(1, t);
    if (s.valid && (s.count != 4 || !(s.value[0] - s.value[0] == 0)))
      std::abort();  // an unchecked command came through
    for (const PlantLink::Sent& sent : (*link)->sent())
      if (sent.datagram.size == 0 || sent.datagram.size > msg::kMaxDatagramBytes) std::abort();
    (*link)->forget_sent();
  }
}

void check(const msg::Datagram& d) {
  if (d.size == 0 || d.size > msg::kMaxDatagramBytes) std::abort();  // an unchecked datagram came through
}

template <class D, class M>
void read_all(hal::Result<D*> device, M& out) {
  if (!device) return;
  for (int i = 0; i < 100; ++i) {
    auto read = (*device)->read(out);
    if (read && !*read) return;
  }
}

void hear_on_a_side_line(std::unique_ptr<hal::Stream> stream) {
  const hal::ManualClock host;
  std::string why;
  auto line = SideLine::open(std::move(stream), "fuzz", 1s, why);
  if (!line) return;
  for (int i = 0; i < 4; ++i) {
    auto e = (*line)->compare_clocks(host);
    if (e && e->answered < e->received) std::abort();  // an unchecked answer came through
  }
  static_cast<void>((*line)->stop());
}

void hear_as_runtime(std::unique_ptr<hal::Stream> stream) {
  static std::vector<std::uint64_t> memory((sizeof(msg::Image) + 1280 * 960 * 3) / 8 + 1);
  auto* image = new (memory.data()) msg::Image;
  image->set_bulk_capacity(1280 * 960 * 3);
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board = SimBoard::open(std::move(stream), options, why);
  if (!board) return;
  msg::ImuSample imu;
  msg::RangeSample range;
  msg::BaroSample baro;
  msg::BatterySample battery;
  msg::SolePressure soles;
  msg::RefereeState referee;
  msg::JointState joints;
  msg::Datagram datagram;
  auto until = (*board)->next_grant({});
  for (bool more = true; more; more = until.has_value()) {
    if (until) clock.set(*until);
    for (const DeviceInfo& d : (*board)->plant().devices) {
      if (d.kind == DeviceKind::imu) read_all((*board)->sensor<msg::ImuSample>(d.name), imu);
      if (d.kind == DeviceKind::range) read_all((*board)->sensor<msg::RangeSample>(d.name), range);
      if (d.kind == DeviceKind::baro) read_all((*board)->sensor<msg::BaroSample>(d.name), baro);
      if (d.kind == DeviceKind::soles) read_all((*board)->sensor<msg::SolePressure>(d.name), soles);
      if (d.kind == DeviceKind::referee) read_all((*board)->sensor<msg::RefereeState>(d.name), referee);
      if (d.kind == DeviceKind::battery) read_all((*board)->sensor<msg::BatterySample>(d.name), battery);
      if (d.kind == DeviceKind::joints) read_all((*board)->sensor<msg::JointState>(d.name), joints);
      if (d.kind == DeviceKind::radio)
        if (auto radio = (*board)->radio(d.name))
          for (int i = 0; i < 100; ++i) {
            auto read = (*radio)->read(datagram);
            if (!read || !*read) break;
            check(datagram);
          }
      if (d.kind == DeviceKind::camera && d.frame_bytes() < 100'000) read_all((*board)->camera(d.name), *image);
    }
    if (until) until = (*board)->next_grant(*until);
  }
}

}  // namespace
}  // namespace sinew::sim_hil

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::sim_hil;
  if (size == 0) return 0;
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> stream(bytes + 1, bytes + size);
  if (data[0] & 4) repair(stream);
  auto peer = std::make_unique<MemoryStream>(std::move(stream), data[0] & 2 ? 13 : SIZE_MAX);
  if (data[0] & 8)
    hear_on_a_side_line(std::move(peer));
  else if (data[0] & 1)
    hear_as_runtime(std::move(peer));
  else
    hear_as_plant(std::move(peer));
  return 0;
}
