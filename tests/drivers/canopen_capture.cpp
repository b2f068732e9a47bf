// Writes what goes over a bus while a CiA 402 drive is found, runs, fails and stops, as a pcap file for other readers.
// usage: canopen_capture OUT.pcap
#include <cstdio>

#include "servo_rig.hpp"

using namespace sinew;
using namespace sinew::drivers;

namespace {

void put32(std::FILE* f, std::uint32_t v) { std::fwrite(&v, 4, 1, f); }  // pcap is in the writer's byte order

/// A frame of link type 227 (CAN_SOCKETCAN): identifier big endian, length, three spare bytes, data.
void put_frame(std::FILE* f, const msg::CanFrame& frame) {
  put32(f, static_cast<std::uint32_t>(frame.stamp.ns / 1'000'000'000));
  put32(f, static_cast<std::uint32_t>(frame.stamp.ns % 1'000'000'000 / 1000));
  put32(f, 16);
  put32(f, 16);
  const std::uint32_t id = frame.id | (frame.extended() ? 0x80000000u : 0u);
  const std::uint8_t head[8] = {static_cast<std::uint8_t>(id >> 24),
                                static_cast<std::uint8_t>(id >> 16),
                                static_cast<std::uint8_t>(id >> 8),
                                static_cast<std::uint8_t>(id),
                                static_cast<std::uint8_t>(frame.size),
                                0,
                                0,
                                0};
  std::fwrite(head, 8, 1, f);
  std::fwrite(frame.data.data(), 8, 1, f);
}

}  // namespace

int main(int argc, char** argv) {
  std::FILE* f = argc == 2 ? std::fopen(argv[1], "wb") : nullptr;
  if (f == nullptr) {
    std::fprintf(stderr, "usage: %s OUT.pcap\n", argv[0]);
    return 2;
  }
  put32(f, 0xA1B2C3D4);
  put32(f, 4u << 16 | 2u);
  put32(f, 0);
  put32(f, 0);
  put32(f, 65535);
  put32(f, 227);
  ServoRig rig;
  ServoConfig c = ServoRig::plain(Protocol::cia402, 5);
  c.device_timeout = std::chrono::milliseconds(50);
  sim_hil::SimServo& drive = rig.add(Protocol::cia402, c);
  sim_hil::MemoryCanPort& ear = rig.bus[0]->wire.attach();
  rig.configure();
  std::uint32_t frames = 0;
  const auto write_down = [&] {
    msg::CanFrame frame;
    while (*ear.read(frame)) {
      put_frame(f, frame);
      ++frames;
    }
  };
  for (int i = 0; i < 1500; ++i) {
    rig.run(std::chrono::milliseconds(1));
    write_down();
    if (i == 1200) drive.fail(0x3210);
  }
  const bool written = std::fclose(f) == 0;
  const bool came_back = rig.sample.ready == 1;
  std::printf("%u frames\n", frames);
  return written && came_back ? 0 : 1;
}
