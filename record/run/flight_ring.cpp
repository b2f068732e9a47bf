#include "record/run/flight_ring.hpp"

#include <algorithm>

#include "rt/saved_state.hpp"

namespace sinew::record {
namespace {

constexpr unsigned kParts = RingMemory::kSlots;
// Room for a part's end, behind its last chunk: verdict, summary, schemas once more.
constexpr std::size_t kEndBytes = 64 * 1024;
// Room for a part's beginning, about: the robot file, schemas, the messages that are latched.
constexpr std::size_t kBeginBytes = 128 * 1024;
// A part lasts at least so long, also when its beginning fills its memory.
constexpr rt::Duration kShortestPart = std::chrono::milliseconds(50);

}  // namespace

FlightRing::FlightRing(const rt::Graph& graph, const RunDescription& description, const RingOptions& options,
                       RingMemory memory)
    : graph_(graph), description_(description), options_(options), memory_(memory) {
  const std::size_t slot = memory_.slot_bytes();
  // A process that dies takes its unfinished chunk along, so chunks are small and short.
  WriterOptions& writer = of_parts_.files.writer;
  writer.chunk_bytes = std::clamp<std::size_t>(slot / 16, 16 * 1024, 64 * 1024);
  writer.chunk_duration = std::chrono::milliseconds(50);
  writer.free_floor_bytes = kEndBytes;
  of_parts_.pixel_room_bytes = room();
  of_parts_.pixels_saved = false;  // each new part would have them again
  of_parts_.pixel_bytes_per_s =
      std::min(options.pixel_bytes_per_s, static_cast<double>(bytes()) / 2 / msg::seconds(options.length));
}

FlightRing::~FlightRing() { wait(); }

hal::Result<std::unique_ptr<FlightRing>> FlightRing::open(const rt::Graph& graph, const RunDescription& description,
                                                          const RingOptions& options) {
  if (options.memory.size() < least_bytes(graph))
    return hal::Error{hal::Errc::bad_argument, "flight ring: bytes of memory, at least",
                      static_cast<std::int64_t>(least_bytes(graph))};
  auto memory = RingMemory::create(options.memory);
  if (!memory) return memory.error();
  return std::unique_ptr<FlightRing>(new FlightRing(graph, description, options, *memory));
}

std::size_t FlightRing::least_bytes(const rt::Graph& graph) {
  std::size_t states = 0;  // a part needs one of each module
  for (const rt::GraphModule& m : graph.modules())
    if (const std::size_t bytes = rt::SavedState(m.declaration).bytes(); bytes > 0)
      states += static_cast<std::size_t>(room_for(bytes));
  return kParts * (kEndBytes + kBeginBytes + states) + 4096;  // and its head
}

bool FlightRing::is_full_for(std::size_t bytes) {
  return sink_ && !dumping_ && sink_->bytes_at_most() + room_for(bytes) >= room();
}

// Two of the slots do not count for the wanted length: the slot that is being filled, and the slot that was emptied for
// it.
bool FlightRing::due(rt::Time now) {
  if (dumping_) return false;  // the dump reads what a new part would overwrite
  if (!sink_) return now - tried_ >= kShortestPart;
  begins_.back() = sink_->began();
  const rt::Duration age = now - sink_->began();
  return age >= options_.length / (kParts - 2) || (age >= kShortestPart && !sink_->trouble()) ||
         (age >= kShortestPart && sink_->bytes_at_most() + of_parts_.files.writer.chunk_bytes * 3 / 2 >= room());
}

void FlightRing::next_part(Beginning beginning) {
  if (sink_) static_cast<void>(sink_->finish());  // an unfinished part can be read, too
  const rt::Time at = tried_ = beginning.at;
  sink_.reset();
  if (begins_.size() == kParts) begins_.erase(begins_.begin());
  begins_.push_back(at);
  auto sink = RunSink::open(
      graph_, description_,
      [this](unsigned) -> hal::Result<std::unique_ptr<hal::OutputFile>> { return memory_.next_part(); }, of_parts_,
      std::move(beginning));
  if (sink)
    sink_ = std::move(*sink);
  else if (trouble_)
    trouble_ = sink.error();
}

std::optional<std::size_t> FlightRing::dump(const std::string& reason, rt::Time now, hal::Os* os) {
  if (dumping_) return std::nullopt;
  dumped_ = now;
  wait();
  std::size_t index = 0;
  {
    const std::lock_guard lock(mutex_);
    index = reports_.size();
    reports_.push_back({.reason = reason, .at = now});
  }
  dumping_ = true;
  if (os) {
    auto thread = os->start_thread({.name = "ring dump", .cpus = {}, .stack_bytes = 128 * 1024, .nice = 5},
                                   [this, index] { write(index); });
    if (thread) {
      thread_ = std::move(*thread);
      return index;
    }
  }
  write(index);
  return index;
}

void FlightRing::write(std::size_t index) {
  auto parts = memory_.parts();
  if (sink_ && !parts.empty()) parts.pop_back();  // the present part, which goes on
  const DumpFile file = options_.next_file();
  RingDumpReport report;
  {
    const std::lock_guard lock(mutex_);
    report = reports_[index];
  }
  report.path = file.path;
  report.status = dump_ring(parts, file, report.reason, options_.free_floor_bytes, report.dumped);
  report.done = true;
  {
    const std::lock_guard lock(mutex_);
    reports_[index] = std::move(report);
  }
  dumping_ = false;
}

std::vector<RingDumpReport> FlightRing::reports() const {
  const std::lock_guard lock(mutex_);
  return reports_;
}

rt::Duration FlightRing::held(rt::Time now) const { return begins_.empty() ? rt::Duration{} : now - begins_.front(); }

}  // namespace sinew::record
