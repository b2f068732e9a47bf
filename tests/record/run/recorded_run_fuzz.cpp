// Any bytes for the readers of a run's recording: review, replay of every module and from a saved state, messages as
// JSON by the definitions in the file. The corpus has no checksums, so that changes reach the contents.
#include <cstdint>
#include <cstdlib>

#include "../memory_file.hpp"
#include "hal/silent_board.hpp"
#include "modules.hpp"
#include "record/run/replay.hpp"
#include "record/run/ros2_json.hpp"
#include "record/run/run_review.hpp"

using namespace sinew;
using namespace sinew::record;

namespace {

// The robot of recorded_robot.hpp, without GoogleTest.
struct Robot {
  Robot() {
    types.add<Numbers>("numbers");
    types.add<Sums>("sums");
    types.add<Pictures>("pictures");
    types.add<Looks>("looks");
    for (const char* name : {"numbers", "sums", "pictures", "looks"}) {
      rt::ModuleSpec m;
      m.name = m.type = name;
      spec.modules.push_back(m);
    }
    spec.modules[1].in = {{"latest", {"numbers.out", 0}}, {"all", {"numbers.out", 0}}};
    spec.modules[3].in = {{"image", {"pictures.image", 0}}};
    add("fast", 3, std::chrono::milliseconds(1), {{"numbers", 0}});
    add("slow", 2, std::chrono::milliseconds(7), {{"sums", 0}});
    add("view", 1, std::chrono::milliseconds(10), {{"pictures", 0}, {"looks", 0}});
    spec.topics.push_back({"pictures.image", Pictures::kBytes, Pictures::kBytes, 5});
    graph = std::make_unique<rt::Graph>(spec, types);
    if (!graph->configure(board)) std::abort();
  }
  void add(const char* name, int priority, rt::Duration period, std::vector<rt::Located<std::string>> order) {
    rt::ThreadSpec t;
    t.name = name, t.priority = priority, t.period = period, t.order = std::move(order);
    spec.threads.push_back(std::move(t));
  }
  rt::ModuleTypes types;
  rt::GraphSpec spec;
  hal::SilentBoard board;
  std::unique_ptr<rt::Graph> graph;
};

void read_all(Reader& reader) {
  std::map<std::uint16_t, std::optional<Ros2Schema>> schemas;
  std::string why, text;
  for (const auto& [id, s] : reader.schemas()) schemas[id] = Ros2Schema::parse(s.name, s.data, why);
  auto messages = reader.messages({});
  Message m;
  for (Next next; (next = messages.next(m)) != Next::end;) {
    text.clear();
    if (next != Next::message || !schemas[m.channel->schema]) continue;
    if (!to_json(*schemas[m.channel->schema], m.data, text) && !text.empty()) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Robot robot;
  const auto bytes = std::as_bytes(std::span(data, size));
  FileProblem problem;
  const auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), problem);
  if (!reader) return 0;
  read_all(*reader);
  static_cast<void>(review(*reader));
  std::string why;
  static_cast<void>(replay(*reader, *robot.graph, {}, why));
  ReplayOptions late;
  late.from_s = 0.015;
  late.chain = true;
  static_cast<void>(replay(*reader, *robot.graph, late, why));
  return 0;
}
