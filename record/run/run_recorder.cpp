#include "record/run/run_recorder.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <optional>

#include "msg/cdr.hpp"
#include "record/later_files.hpp"
#include "record/queued_file.hpp"
#include "record/run/ring_trigger.hpp"
#include "record/run/run_messages.hpp"
#include "rt/parameters.hpp"
#include "rt/saved_state.hpp"
#include "rt/slot_reader.hpp"

namespace sinew::record {
namespace {

constexpr std::size_t kBatchBytes = 16 * 1024;
constexpr rt::Duration kBatchAge = std::chrono::milliseconds(50);
// Pause between asking two modules for their states: the copies take the executor's time.
constexpr rt::Duration kAskEvery = std::chrono::milliseconds(10);

/// By topic: how many of its messages a step may hold.
std::vector<std::uint32_t> depths(const rt::Graph& graph) {
  std::vector<std::uint32_t> depth(graph.topics().size());
  for (const rt::GraphModule& m : graph.modules())
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (m.topic[p] != rt::kNone && m.declaration.ports[p].kind != rt::Declaration::PortKind::output)
        depth[m.topic[p]] = std::max(depth[m.topic[p]], m.declaration.ports[p].depth);
  return depth;
}

/// The same files, each behind memory that takes what comes while the disk stalls.
SplitWriter::OpenPart behind_memory(SplitWriter::OpenPart open_part, std::uint64_t bytes, hal::Os& os) {
  return [open_part = std::move(open_part), memory = std::make_shared<QueueMemory>(bytes), &os](unsigned part) {
    auto file = open_part(part);
    return file ? QueuedFile::open(std::move(*file), memory, os) : std::move(file);
  };
}

/// The same files, of which the recorder's thread makes none but the first one.
SplitWriter::OpenPart made_beside(SplitWriter::OpenPart open_part, hal::Os& os) {
  return [later = std::make_shared<LaterFiles>(std::move(open_part), os)](unsigned part) { return later->open(part); };
}

}  // namespace

class RunRecorder::Body final : public rt::RunObserver, StepLog::Visitor {
 public:
  Body(rt::Graph& graph, Pace pace, RunDescription description, const RecorderOptions& options)
      : graph_(graph),
        pace_(pace),
        description_(std::move(description)),
        options_(options),
        log_(graph, options.log_room, options.state_every),
        trigger_(graph),
        batches_(graph.threads().size()),
        entries_(graph.threads().size()) {
    const auto depth = depths(graph);
    for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
      topics_.push_back({.type = graph.topics()[t].type, .depth = depth[t]});
      topics_.back().reader.emplace(graph.segment(), graph.recorder_taps()[t]);
    }
    for (const rt::GraphModule& m : graph.modules()) layouts_.push_back(rt::SavedState(m.declaration).layout());
    for (const rt::GraphModule& m : graph.modules())
      for (const auto& p : m.declaration.params)
        params_.emplace(m.spec.name + "." + p.name, rt::to_string(rt::current(p)));
  }
  ~Body() override { stop_thread(); }

  hal::Status open(SplitWriter::OpenPart open_part) {
    if (open_part)
      if (auto begun = begin_file(std::move(open_part)); !begun) return begun;
    if (options_.ring.length.count() == 0) return {};
    auto ring = FlightRing::open(graph_, description_, options_.ring);
    if (!ring) return ring.error();
    ring_ = std::move(*ring);
    next_part();
    return {};
  }

  hal::Status start(hal::Os& os) {
    os_ = &os;
    hal::ThreadOptions thread;
    thread.name = "recorder";
    thread.stack_bytes = 128 * 1024;
    thread.nice = -10;  // below all real-time threads, but not starved by ordinary programs
    auto started = os.start_thread(thread, [this] { follow(); });
    if (!started) return started.error();
    thread_ = std::move(*started);
    return {};
  }

  bool later(std::function<void()> what) {
    const std::lock_guard lock(mutex_);
    if (finished_) return false;
    asked_.push_back(std::move(what));
    any_asked_.store(true, std::memory_order_release);
    return true;
  }

  RecorderProgress progress() const {
    const std::lock_guard lock(progress_mutex_);
    return progress_;
  }

  bool finished() const { return finished_; }
  hal::Status finish(const RunEnd& end) {
    stop_thread();
    read_all(true);
    between();
    {
      const std::lock_guard lock(mutex_);
      finished_ = true;
    }
    between();  // runs what was asked meanwhile
    if (ring_) {
      ring_->wait();
      if (why_dump_) static_cast<void>(snapshot(*why_dump_));
      ring_->wait();
    }
    return has_file() ? end_file(end) : hal::Status{};
  }

  // ---- the recordings

  bool has_file() const { return file_ && !file_ended_; }
  rt::Time now() const { return now_; }
  const RunSink* file() const { return file_.get(); }
  FlightRing* ring() const { return ring_.get(); }

  hal::Status begin_file(SplitWriter::OpenPart open_part) {
    if (has_file()) return hal::Error{hal::Errc::busy, "recorder: a file is being written"};
    if (pace_ == Pace::follows && options_.disk_os && options_.buffer_bytes != 0)
      open_part =
          made_beside(behind_memory(std::move(open_part), options_.buffer_bytes, *options_.disk_os), *options_.disk_os);
    auto sink = RunSink::open(graph_, description_, std::move(open_part),
                              {.files = options_.files,
                               .topics = options_.topics,
                               .threads = options_.threads,
                               .rate_hz = options_.rate_hz,
                               .pixel_bytes_per_s = options_.pixel_bytes_per_s},
                              begin());
    if (!sink) return sink.error();
    file_ = std::move(*sink), file_ended_ = false;
    tell_older(*file_);
    files_told_ = file_->files();
    tell_progress();
    return {};
  }

  hal::Status end_file(const RunEnd& end) {
    if (!has_file()) return hal::Error{hal::Errc::not_found, "recorder: no file is being written"};
    flush_batches();
    file_ended_ = true;
    tell_progress();
    return file_->finish(end);
  }

  std::optional<std::size_t> snapshot(const std::string& reason) {
    if (!ring_ || ring_->is_dumping()) return std::nullopt;
    next_part();
    return ring_->dump(reason, now_, pace_ == Pace::follows ? os_ : nullptr);
  }

  // ---- of the executor's threads
  void completed(const rt::StepRecord& record) noexcept override {
    log_.completed(record);
    if (pace_ == Pace::waited_for) read_now(record.thread);
  }
  void taken(const rt::Request& request, const rt::Effect& effect, rt::Time now) noexcept override {
    log_.taken(request, effect, now);
    if (pace_ == Pace::waited_for) read_now(request.thread);
  }

 private:
  struct Topic {
    const msg::TypeInfo* type = nullptr;
    std::uint32_t depth = 0;  // a step may hold this many of its messages
    std::optional<rt::SlotReader> reader{};
    std::optional<std::uint32_t> newest{};  // sequence that a step named
  };

  /// The beginning of a recording that begins now. Everything reported before is in the present recordings.
  Beginning begin() {
    flush_batches();
    const bool midway = std::any_of(entries_.begin(), entries_.end(), [](auto n) { return n != 0; });
    return {midway, now_, entries_, params_};
  }

  /// Messages published before a recording begins that its first steps may have latched.
  void tell_older(RunSink& sink) {
    for (std::uint32_t t = 0; t < topics_.size(); ++t) {
      Topic& topic = topics_[t];
      if (!topic.newest || topic.depth == 0 || !sink.takes_all(t)) continue;
      const std::uint32_t most = topic.depth + 1;  // a step that has not completed may hold an older one
      std::uint32_t there = 0;
      while (there < most && topic.reader->pin(*topic.newest - there)) topic.reader->unpin(), ++there;
      sink.lacks_until(t, *topic.newest - there);
      for (; there > 0; --there) {
        const std::uint32_t sequence = *topic.newest - (there - 1);
        const rt::SlotHeader* slot = topic.reader->pin(sequence);
        if (!slot) {
          sink.lacks_until(t, sequence);
          continue;
        }
        sink.put_older(t, form(topic, *slot));
        topic.reader->unpin();
      }
    }
  }

  /// The same for another file of a split recording: what the file before has, and steps may hold.
  void tell_again(RunSink& sink) {
    files_told_ = sink.files();
    for (std::uint32_t t = 0; t < topics_.size(); ++t) {
      Topic& topic = topics_[t];
      if (!topic.newest || topic.depth == 0 || topic.type->has_bulk() || !sink.takes_all(t)) continue;
      for (std::uint32_t back = topic.depth + 1; back > 0; --back) {
        const rt::SlotHeader* slot = topic.reader->pin(*topic.newest - (back - 1));
        if (!slot) continue;
        sink.put_again(t, form(topic, *slot));
        topic.reader->unpin();
      }
    }
  }

  void next_part() {
    ring_->next_part(begin());
    if (ring_->sink()) tell_older(*ring_->sink());
  }

  template <class F>
  void each_sink(F&& f) {
    if (has_file()) f(*file_);
    if (ring_ && ring_->sink()) f(*ring_->sink());
  }

  // ---- what the log tells

  void step(const LoggedStep& s) override {
    now_ = std::max(now_, s.completed);
    ++entries_[s.thread];
    each_sink([&](RunSink& sink) {
      if (sink.takes_thread(s.thread)) sink.step(s), put_held(sink, s);
    });
    for (const LoggedStep::Output& out : s.outputs) {
      const std::uint32_t topic = graph_.modules()[s.module].topic[out.port];
      topics_[topic].newest = out.first + out.count - 1;
      for (std::uint32_t i = 0; i < out.count; ++i) message(topic, out.first + i, s.completed);
    }
    StepBatch& batch = batches_[s.thread];
    batch.add(s);
    if (batch.bytes().size() >= kBatchBytes || s.completed - batch.first() >= kBatchAge) flush_batch(s.thread);
    if (auto why = trigger_.step(s)) happened(std::move(*why));
  }

  /// Messages of threads whose steps the file does not have.
  void put_held(RunSink& sink, const LoggedStep& s) {
    for (const LoggedStep::Input& in : s.inputs) {
      const std::uint32_t index = graph_.modules()[s.module].topic[in.port];
      for (const std::uint32_t sequence : in.sequences) {
        if (!sink.takes_held(index, sequence)) continue;
        Topic& topic = topics_[index];
        const rt::SlotHeader* slot = topic.reader->pin(sequence);
        if (!slot) {
          sink.lose(index, s.now);
          continue;
        }
        sink.put(index, form(topic, *slot), s.now);
        topic.reader->unpin();
      }
    }
  }

  void request(const LoggedRequest& r) override {
    ++entries_[r.request.thread];
    flush_batch(r.request.thread);  // so that the file keeps their order
    encode(scratch_, r);
    each_sink([&](RunSink& sink) {
      if (sink.takes_thread(r.request.thread)) sink.request(r, scratch_.bytes());
    });
    trigger_.request(r);
    follow_param(r);
  }

  void follow_param(const LoggedRequest& r) {
    if (r.request.kind != rt::Request::Kind::set_param || r.effect.refused) return;
    const rt::GraphModule& m = graph_.modules()[r.request.module];
    const auto& param = m.declaration.params[r.request.index];
    const bool is_number = std::holds_alternative<double*>(param.target);
    rt::ParamValue value = std::visit([](auto v) { return rt::ParamValue(v); }, r.request.value);
    if (const auto* whole = std::get_if<std::int64_t>(&value); whole && is_number) value = static_cast<double>(*whole);
    const std::string name = m.spec.name + "." + param.name;
    params_[name] = rt::to_string(value);
    each_sink([&](RunSink& sink) { sink.set_param(name, params_[name]); });
  }

  void state(const LoggedState& s) override {
    if (ring_ && ring_->is_full_for(s.bytes.size())) next_part();
    ++entries_[s.thread];
    flush_batch(s.thread);
    encode(scratch_, s, layouts_[s.module]);
    each_sink([&](RunSink& sink) {
      if (sink.takes_thread(s.thread)) sink.state(s, scratch_.bytes());
    });
  }

  void lost(std::uint32_t thread, std::uint64_t entries) override {
    entries_[thread] += entries;
    flush_batch(thread);
    each_sink([&](RunSink& sink) {
      if (sink.takes_thread(thread)) sink.lost(thread, entries, now_);
    });
  }

  void flush_batch(std::uint32_t thread) {
    StepBatch& batch = batches_[thread];
    if (batch.empty()) return;
    each_sink([&](RunSink& sink) {
      if (sink.takes_thread(thread)) sink.steps(thread, batch);
    });
    batch.clear();
  }
  void flush_batches() {
    for (std::uint32_t t = 0; t < batches_.size(); ++t) flush_batch(t);
  }

  void message(std::uint32_t index, std::uint32_t sequence, rt::Time at) {
    std::array<RunSink*, 2> takers{};
    std::size_t count = 0;
    each_sink([&](RunSink& sink) {
      if (sink.takes(index, at)) takers[count++] = &sink;
    });
    const bool is_safety = ring_ && trigger_.is_safety(index);
    if (count == 0 && !is_safety) return;
    Topic& topic = topics_[index];
    const rt::SlotHeader* slot = topic.reader->pin(sequence);
    if (!slot) {
      for (std::size_t i = 0; i < count; ++i) takers[i]->lose(index, at);
      return;
    }
    const SinkMessage message = form(topic, *slot);
    for (std::size_t i = 0; i < count; ++i) takers[i]->put(index, message, at);
    if (is_safety)
      if (auto why = trigger_.safety(*static_cast<const msg::SafetyState*>(slot->message()))) happened(std::move(*why));
    topic.reader->unpin();
  }

  SinkMessage form(const Topic& topic, const rt::SlotHeader& slot) {
    if (topic.type->has_bulk()) return {&slot, {}, head_of(*static_cast<const msg::Image*>(slot.message()), false)};
    message_.resize(msg::cdr_size(*topic.type, slot.message()));
    msg::cdr_encode(*topic.type, slot.message(), {reinterpret_cast<std::uint8_t*>(message_.data()), message_.size()});
    return {&slot, message_.bytes(), {}};
  }

  // ---- between two messages

  void happened(std::string why) {
    if (!ring_) return;
    if (why_dump_) return ring_->count_only();
    if (!ring_->may_dump(now_)) why += " at " + seconds_text(now_);  // the dump comes later
    why_dump_ = std::move(why);
  }

  void between() {
    if (any_asked_.load(std::memory_order_acquire)) answer();
    if (has_file() && file_->files() != files_told_) tell_again(*file_);
    if (now_ >= next_progress_) tell_progress();
    if (now_ >= next_ask_) ask_for_state();
    if (!ring_) return;
    if (why_dump_ && ring_->may_dump(now_)) {
      if (snapshot(*why_dump_)) why_dump_.reset();
    } else if (ring_->due(now_)) {
      next_part();
    }
  }

  void tell_progress() {
    next_progress_ = now_ + options_.poll;
    RecorderProgress progress{.now = now_};
    if (has_file()) {
      RecorderProgress::File& file = progress.file.emplace(RecorderProgress::File{});
      file.began = file_->began();
      file.files = file_->files();
      for (const auto& [topic, lost] : file_->lost_messages()) file.lost_messages += lost.count;
      for (const auto& [thread, lost] : file_->lost_steps()) file.lost_steps += lost.count;
    }
    if (ring_) progress.ring = {ring_->held(now_), ring_->bytes_used(), ring_->trouble()};
    const std::lock_guard lock(progress_mutex_);
    progress_ = progress;
  }

  void answer() {
    std::vector<std::function<void()>> asked;
    {
      const std::lock_guard lock(mutex_);
      asked.swap(asked_);
      any_asked_.store(false, std::memory_order_relaxed);
    }
    for (const auto& what : asked) what();
  }

  /// One module at a time.
  void ask_for_state() {
    next_ask_ = now_ + kAskEvery;
    for (std::uint32_t i = 0; i < layouts_.size(); ++i) {
      const auto m = static_cast<std::uint32_t>((asked_last_ + 1 + i) % layouts_.size());
      bool needed = false;
      each_sink([&](const RunSink& sink) { needed |= sink.needs_state(m); });
      if (!needed) continue;
      asked_last_ = m;
      return log_.ask_state(m);
    }
  }

  // ---- the thread

  void follow() {
    while (!stop_.load(std::memory_order_relaxed)) {
      read_all(false, os_->now() + -options_.poll);
      between();
      each_sink([&](RunSink& sink) { sink.tick(now_); });
      os_->sleep_until(os_->now() + options_.poll);
    }
  }
  void stop_thread() {
    stop_.store(true, std::memory_order_relaxed);
    thread_.reset();  // joins
  }
  /// `until` lies some time ago, so that the publisher of a held message has reported it, too: a recording that begins
  /// or ends here lacks no message that its steps name.
  void read_all(bool last, rt::Time until = rt::Time{INT64_MAX}) {
    for (std::uint32_t t = 0; t < log_.threads(); ++t) log_.read(t, *this, last, until);
  }
  void read_now(std::uint32_t thread) {
    log_.read(thread, *this);
    between();
  }

  rt::Graph& graph_;
  const Pace pace_;
  const RunDescription description_;
  const RecorderOptions options_;
  StepLog log_;
  RingTrigger trigger_;
  std::vector<Topic> topics_;
  std::vector<StepBatch> batches_;      // per thread
  std::vector<std::uint64_t> entries_;  // per thread: entries of its log, lost ones included
  std::vector<std::uint64_t> layouts_;  // per module
  Texts params_;                        // as they are now
  Buffer scratch_, message_;
  rt::Time now_;  // of the newest reported step
  std::unique_ptr<RunSink> file_;
  bool file_ended_ = false;
  unsigned files_told_ = 0;  // of those: each has the messages that its first steps hold
  std::unique_ptr<FlightRing> ring_;
  std::optional<std::string> why_dump_;
  rt::Time next_ask_;
  std::uint32_t asked_last_ = 0;
  hal::Os* os_ = nullptr;
  rt::Time next_progress_;
  mutable std::mutex progress_mutex_;
  RecorderProgress progress_;
  std::mutex mutex_;  // of the jobs of later()
  std::vector<std::function<void()>> asked_;
  std::atomic<bool> any_asked_{false};
  bool finished_ = false;
  std::atomic<bool> stop_{false};
  std::unique_ptr<hal::Thread> thread_;
};

hal::Result<std::unique_ptr<RunRecorder>> RunRecorder::open(rt::Graph& graph, Pace pace,
                                                            SplitWriter::OpenPart open_part, RunDescription description,
                                                            const RecorderOptions& options) {
  auto body = std::make_unique<Body>(graph, pace, std::move(description), options);
  if (auto opened = body->open(std::move(open_part)); !opened) return opened.error();
  return std::unique_ptr<RunRecorder>(new RunRecorder(std::move(body)));
}

RunRecorder::RunRecorder(std::unique_ptr<Body> body) : body_(std::move(body)) {}
// The record of a failed run is the most interesting one: it is completed all the same.
RunRecorder::~RunRecorder() {
  if (!body_->finished()) static_cast<void>(body_->finish({}));
}
rt::RunObserver& RunRecorder::observer() { return *body_; }
hal::Status RunRecorder::start(hal::Os& os) { return body_->start(os); }
bool RunRecorder::later(std::function<void()> what) { return body_->later(std::move(what)); }
RecorderProgress RunRecorder::progress() const { return body_->progress(); }
hal::Status RunRecorder::finish(const RunEnd& end) { return body_->finish(end); }
hal::Status RunRecorder::begin_file(SplitWriter::OpenPart open_part) { return body_->begin_file(std::move(open_part)); }
hal::Status RunRecorder::end_file(const RunEnd& end) { return body_->end_file(end); }
bool RunRecorder::has_file() const { return body_->has_file(); }
rt::Time RunRecorder::now() const { return body_->now(); }
std::optional<std::size_t> RunRecorder::snapshot(const std::string& reason) { return body_->snapshot(reason); }
const RunSink* RunRecorder::file() const { return body_->file(); }
const FlightRing* RunRecorder::ring() const { return body_->ring(); }

}  // namespace sinew::record
