// Any bytes as the memory of a robot: the reader opens it or not, and never reads outside of it. The input is bytes
// laid over the memory of a real segment: pairs of place and value, of four bytes each.
#include <cstdlib>
#include <cstring>
#include <memory>

#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "rt/commit.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::tap {
namespace {

struct Memory {
  std::unique_ptr<rt::Segment> segment;
  std::size_t bytes;
  Memory() {
    rt::SegmentPlan plan({.first_sequence = 0xFFFFFFFE, .records = 4});
    const auto w = plan.add_writer("w"), camera = plan.add_writer("camera");
    plan.add_topic(w, {"w.range", &msg::type_info<msg::RangeSample>(), 0, 2, 3, 0});
    plan.add_topic(w, {"w.imu", &msg::type_info<msg::ImuSample>(), 0, 1, 2, 0});
    plan.add_topic(camera, {"camera.image", &msg::type_info<msg::Image>(), 256, 1, 2, 0});
    segment = std::make_unique<rt::Segment>(plan);
    rt::Commit commit(*segment, w), frames(*segment, camera);
    for (int i = 0; i < 7; ++i) {
      static_cast<msg::RangeSample*>(commit.try_loan(0))->range_m = i;
      static_cast<msg::ImuSample*>(commit.try_loan(1))->gyro_radps.x = i;
      commit.commit({});
      if (!static_cast<msg::Image*>(frames.try_loan(0))->format_as(msg::PixelFormat::mono8, 16, 16)) std::abort();
      frames.commit({});
    }
    bytes = static_cast<std::size_t>(segment->header().bytes);
  }
  const std::byte* data() const { return reinterpret_cast<const std::byte*>(&segment->header()); }
};

std::uint64_t look_at_all(const SegmentReader& reader) {
  std::uint64_t sum = 0;
  for (std::uint32_t t = 0; t < reader.topics().size() && t < 64; ++t) {
    if (reader.bytes(t) > (1U << 20)) continue;
    std::vector<std::byte> copy(reader.bytes(t));
    Cursor cursor;
    cursor.started = true, cursor.next = 0xFFFFFFFE;
    for (int i = 0; i < 8; ++i) {
      const auto m = i == 0 ? reader.newest(t) : reader.next(t, cursor);
      if (m && reader.copy(*m, copy)) sum += std::to_integer<std::uint8_t>(copy.back());
    }
  }
  return sum;
}

}  // namespace
}  // namespace sinew::tap

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::tap;
  static const Memory original;
  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };
  const std::unique_ptr<std::byte[], Free> memory(static_cast<std::byte*>(std::aligned_alloc(4096, original.bytes)));
  std::memcpy(memory.get(), original.data(), original.bytes);
  for (; size >= 8; data += 8, size -= 8) {
    std::uint32_t at = 0;
    std::memcpy(&at, data, 4);
    std::memcpy(memory.get() + at % (original.bytes - 3), data + 4, 4);
  }
  // The end of the memory moves too: the reader must not touch bytes behind it.
  const auto reader = SegmentReader::open({memory.get(), original.bytes - (size & 4 ? 64 : 0)});
  return reader && look_at_all(*reader) == UINT64_MAX ? 1 : 0;
}
