// Any bytes as a message from outside, in memory of any length at any place: what an external topic accepts is a whole
// image within the topic's limits, or finite numbers; what it refuses leaves its place free.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "hal/board.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/external_source.hpp"

namespace sinew::rt {
namespace {

constexpr std::uint32_t kPixels = 32 * 24, kBytes = 2 * kPixels;

void require(bool holds) {
  if (!holds) std::abort();
}

class Ticks final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    out_.loan().stamp = step.now;
    return StepStatus::ok;
  }

 private:
  rt::Out<msg::RangeSample> out_;
};

GraphSpec spec() {
  GraphSpec g;
  ModuleSpec ticks;
  ticks.name = "ticks", ticks.type = "Ticks";
  g.modules = {ticks};
  ThreadSpec loop;
  loop.name = "loop", loop.priority = 1, loop.period = std::chrono::milliseconds(1), loop.order = {{"ticks", 0}};
  g.threads = {loop};
  g.topics = {TopicSpec{"outside.image", kBytes, 0, 0, ExternalSpec{"Image", "loop"}, kPixels},
              TopicSpec{"outside.range", 0, 0, 0, ExternalSpec{"RangeSample", "loop"}}};
  return g;
}

/// Made once; its places wait for messages, and it never runs.
struct StandingRobot {
  Graph graph;
  hal::EmptyBoard board;
  hal::ManualClock clock;
  hal::FixedGrant grants{Time{}};
  std::unique_ptr<DiscreteExecutor> executor;
  ExternalSource* source = nullptr;
  static ModuleTypes types() {
    ModuleTypes t;
    t.add<Ticks>("Ticks");
    return t;
  }
  StandingRobot() : graph(spec(), types()) {
    require(graph.check().empty() && graph.configure(board));
    executor = std::make_unique<DiscreteExecutor>(graph, clock, grants);
    for (GraphModule& m : graph.modules())
      if (m.external) source = m.external;
  }
};

class Memory final : public hal::SharedMemory {
 public:
  explicit Memory(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::byte* data() override { return nullptr; }
  std::size_t size() const override { return bytes_.size(); }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset) return false;
    if (!into.empty()) std::memcpy(into.data(), bytes_.data() + offset, into.size());
    return true;
  }

 private:
  std::span<const std::byte> bytes_;
};

void check_accepted(const StandingRobot& robot, std::uint32_t place, std::uint32_t port) {
  const auto message = robot.source->message_of(place);
  require(robot.source->port_of(place) == port);
  if (port == 1) {
    msg::RangeSample sample;
    require(message.size() == sizeof sample);
    std::memcpy(&sample, message.data(), sizeof sample);
    require(std::isfinite(sample.range_m));
    return;
  }
  const auto& image = *reinterpret_cast<const msg::Image*>(message.data());
  require(image.capacity_bytes == kBytes && message.size() == sizeof image + image.bulk_used());
  require(image.width > 0 && image.height > 0 && image.width * image.height <= kPixels);
  require(msg::bytes_per_pixel(image.format) != 0 && image.stride >= image.width * msg::bytes_per_pixel(image.format));
  require(std::uint64_t{image.stride} * image.height <= kBytes);
}

}  // namespace
}  // namespace sinew::rt

/// Port, offset (16 bits), length (32 bits), and the memory.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::rt;
  static const StandingRobot robot;
  if (size < 7) return 0;
  const std::uint32_t port = data[0] & 1;
  std::uint16_t offset = 0;
  std::uint32_t length = 0;
  std::memcpy(&offset, data + 1, sizeof offset);
  std::memcpy(&length, data + 3, sizeof length);
  const Memory memory(std::as_bytes(std::span(data + 7, size - 7)));
  const auto place = robot.source->stage(port, {.memory = &memory, .offset = offset, .size = length});
  if (place) {
    check_accepted(robot, *place, port);
    robot.source->unstage(*place);
  } else {
    require(place.error().code != sinew::hal::Errc::busy);
  }
  return 0;
}
