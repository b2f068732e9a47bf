// Any bytes on the socket, in any pieces: frames are cut within their bounds, every request gets one reply that is a
// JSON object with "ok", and a robot that stands still only takes what its mailboxes hold.
#include <cstdlib>

#include "hal/board.hpp"
#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "tap/answers.hpp"
#include "tap/frames.hpp"
#include "tap_graph.hpp"

namespace sinew::tap {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

/// What a client has handed over: 64 bytes of ones and zeros.
class HandedOver final : public hal::SharedMemory {
 public:
  std::byte* data() override { return nullptr; }
  std::size_t size() const override { return 64; }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    if (offset > size() || into.size() > size() - offset) return false;
    for (std::byte& b : into) b = static_cast<std::byte>(offset++ & 1);
    return true;
  }
};

/// Made once: requests that the fuzzer leaves in its mailboxes stay there.
struct StandingRobot {
  rt::Graph graph{robot_spec({.camera = true}), robot_types()};
  hal::EmptyBoard board;
  hal::ManualClock clock;
  hal::FixedGrant grants{hal::Time{}};
  std::unique_ptr<rt::DiscreteExecutor> executor;
  std::unique_ptr<Answers> answers;
  StandingRobot() {
    require(graph.check().empty() && graph.configure(board));
    executor = std::make_unique<rt::DiscreteExecutor>(graph, clock, grants);
    answers = std::make_unique<Answers>(graph, executor->runner(), hal::system_os(),
                                        Answers::Robot{"robot", "none", true, [] {}});
    answers->set_memory(1, std::make_unique<HandedOver>());
  }
};

void answer(Answers& answers, std::string_view request) {
  const Reply reply = answers.answer(request, 1);
  answers.follow();
  require(reply.memory == nullptr);  // this robot has none to hand out
  const Json& json = reply.change ? reply.change->reply : reply.json;
  require(json.is_object() && json.contains("ok") && json["ok"].is_boolean());
  if (json["ok"] == false) {
    require(json["error"]["why"].get_ref<const std::string&>().size() > 2);
    require(!reply.change);
  }
  require(to_text(json).size() < kMaxReplyBytes);
  require(to_text(reply).size() < kMaxReplyBytes);
}

}  // namespace
}  // namespace sinew::tap

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::tap;
  static StandingRobot robot;
  // The first byte is the size of the pieces.
  if (size == 0) return 0;
  const std::size_t piece = data[0] + 1U;
  FrameReader frames(kMaxRequestBytes);
  for (std::size_t at = 1; at < size && !frames.broken();) {
    const auto room = frames.room();
    require(!room.empty());
    const std::size_t n = std::min({piece, size - at, room.size()});
    std::copy_n(reinterpret_cast<const std::byte*>(data + at), n, room.begin());
    frames.filled(n);
    at += n;
    if (const auto frame = frames.frame()) {
      require(frame->size() <= kMaxRequestBytes);
      answer(*robot.answers, *frame);
      frames.drop();
    }
  }
  return 0;
}
