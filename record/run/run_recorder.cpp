#include "record/run/run_recorder.hpp"

#include <algorithm>
#include <atomic>
#include <optional>

#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/run_messages.hpp"
#include "rt/parameters.hpp"
#include "rt/saved_state.hpp"
#include "rt/slot_reader.hpp"

namespace sinew::record {
namespace {

constexpr std::size_t kBatchBytes = 16 * 1024;
constexpr rt::Duration kBatchAge = std::chrono::milliseconds(50);

std::string number_key(std::size_t i) {
  std::string text = std::to_string(i);
  return std::string(text.size() < 3 ? 3 - text.size() : 0, '0') + text;  // in the order of the map
}

// Bytes that may be used up at a rate, and saved for a second.
class Budget {
 public:
  explicit Budget(double per_s) : per_s_(per_s), left_(per_s) {}
  bool take(std::size_t bytes, rt::Time now) {
    if (now > last_) left_ = std::min(per_s_, left_ + per_s_ * msg::seconds(now - last_));
    last_ = std::max(last_, now);
    if (static_cast<double>(bytes) > left_) return false;
    left_ -= static_cast<double>(bytes);
    return true;
  }

 private:
  double per_s_, left_;
  rt::Time last_;
};

}  // namespace

class RunRecorder::Body final : public rt::RunObserver, StepLog::Visitor {
 public:
  Body(rt::Graph& graph, Pace pace, RunDescription description, const RecorderOptions& options)
      : graph_(graph),
        pace_(pace),
        description_(std::move(description)),
        options_(options),
        log_(graph, options.log_room, options.state_every),
        budget_(options.pixel_bytes_per_s),
        batches_(graph.threads().size()),
        lost_entries_(graph.threads().size()),
        entries_(graph.threads().size()) {
    for (std::uint32_t t = 0; t < graph.topics().size(); ++t) topics_.push_back(make_topic(t));
    for (const rt::GraphModule& m : graph.modules()) layouts_.push_back(rt::SavedState(m.declaration).layout());
    for (const rt::GraphModule& m : graph.modules())
      for (const auto& p : m.declaration.params)
        params_.emplace(m.spec.name + "." + p.name, rt::to_string(rt::current(p)));
  }
  ~Body() override { stop_thread(); }

  hal::Status open(SplitWriter::OpenPart open_part) {
    auto writer = SplitWriter::open(
        std::move(open_part), [this](Writer& w, unsigned part) { return begin_file(w, part); }, options_.files);
    if (!writer) return writer.error();
    writer_.emplace(std::move(*writer));
    return add_channels();
  }

  hal::Status start(hal::Os& os) {
    os_ = &os;
    hal::ThreadOptions thread;
    thread.name = "recorder";
    thread.stack_bytes = 128 * 1024;
    thread.nice = -10;  // still below everything real-time, but not starved by what else the machine does
    auto started = os.start_thread(thread, [this] { follow(); });
    if (!started) return started.error();
    thread_ = std::move(*started);
    return {};
  }

  bool finished() const { return finished_; }
  hal::Status finish() {
    finished_ = true;
    stop_thread();
    read_all(true);
    for (std::uint32_t t = 0; t < batches_.size(); ++t) flush_batch(t);
    Texts verdicts;
    for (const ModuleVerdict& v : verdict()) verdicts.emplace(v.module, to_text(v));
    Texts losses, entries, newest;
    for (const auto& [name, lost] : lost_messages()) losses.emplace(name, to_text(lost, "messages"));
    for (const auto& [name, lost] : lost_steps()) losses.emplace("thread " + name, to_text(lost, "steps"));
    for (std::size_t t = 0; t < entries_.size(); ++t) entries.emplace(number_key(t), std::to_string(entries_[t]));
    for (const Topic& t : topics_)
      if (t.newest) newest.emplace(t.kept.name, std::to_string(*t.newest));
    note(writer_->writer().add_metadata({"sinew.entries", std::move(entries)}));
    note(writer_->writer().add_metadata({"sinew.newest", std::move(newest)}));
    note(writer_->writer().add_metadata({"sinew.verdict", std::move(verdicts)}));
    note(writer_->writer().add_metadata({"sinew.losses", std::move(losses)}));
    return writer_->finish();
  }

  // ---- of the executor's threads
  void completed(const rt::StepRecord& record) noexcept override {
    log_.completed(record);
    if (pace_ == Pace::waited_for) log_.read(record.thread, *this);
  }
  void taken(const rt::Request& request, const rt::Effect& effect, rt::Time now) noexcept override {
    log_.taken(request, effect, now);
    if (pace_ == Pace::waited_for) log_.read(request.thread, *this);
  }

  // ---- after the end
  std::vector<ModuleVerdict> verdict() const {
    std::vector<ModuleVerdict> all;
    for (const rt::GraphModule& m : graph_.modules()) all.push_back({m.spec.name, why_not(m)});
    return all;
  }
  std::map<std::string, Losses> lost_messages() const {
    std::map<std::string, Losses> lost;
    for (const Topic& t : topics_)
      if (t.kept.lost.count != 0) lost.emplace(t.about->name, t.kept.lost);
    return lost;
  }
  std::map<std::string, Losses> lost_steps() const {
    std::map<std::string, Losses> lost;
    for (std::size_t t = 0; t < lost_entries_.size(); ++t)
      if (lost_entries_[t].count != 0) lost.emplace(graph_.threads()[t].spec.name, lost_entries_[t]);
    return lost;
  }

  hal::Status trouble_;
  unsigned parts() const { return writer_->part() + 1; }

 private:
  struct Topic {
    const rt::GraphTopic* about = nullptr;
    TopicKept kept;
    std::optional<rt::SlotReader> reader;
    std::uint16_t channel = 0, head_channel = 0;
    std::optional<std::uint32_t> newest;  // sequence that a step named
    rt::Time next;                        // rate_hz: not before
  };

  Topic make_topic(std::uint32_t index) {
    Topic t;
    t.about = &graph_.topics()[index];
    const auto& some = options_.topics;
    t.kept.name = t.about->name;
    t.kept.wanted = some.empty() || std::find(some.begin(), some.end(), t.about->name) != some.end();
    if (const auto rate = options_.rate_hz.find(t.about->name); rate != options_.rate_hz.end())
      t.kept.rate_hz = rate->second;
    t.reader.emplace(graph_.segment(), graph_.recorder_taps()[index]);
    return t;
  }

  // ---- the file

  hal::Status begin_file(Writer& w, unsigned part) {
    Texts modules, threads, chains, run = description_.run;
    run["unix_ns"] = std::to_string(description_.unix_ns);
    run["part"] = std::to_string(part);
    for (std::size_t i = 0; i < graph_.modules().size(); ++i)
      modules.emplace(number_key(i), graph_.modules()[i].spec.name);
    for (std::size_t i = 0; i < graph_.threads().size(); ++i)
      threads.emplace(number_key(i), graph_.threads()[i].spec.name);
    for (std::size_t i = 0; i < graph_.chains().size(); ++i)
      chains.emplace(number_key(i), graph_.chains()[i].spec.name);
    const Metadata all[] = {{"sinew.run", std::move(run)},         {"sinew.modules", std::move(modules)},
                            {"sinew.threads", std::move(threads)}, {"sinew.chains", std::move(chains)},
                            {"sinew.graph", graph_texts()},        {"sinew.params", params_}};
    for (const Metadata& m : all)
      if (auto added = w.add_metadata(m); !added) return added;
    for (const Attachment& a : description_.attachments)
      if (auto added = w.attach(a); !added) return added;
    return {};
  }

  /// Of each module its thread, and of each port its topic.
  Texts graph_texts() const {
    Texts texts;
    for (std::size_t i = 0; i < graph_.modules().size(); ++i) {
      const rt::GraphModule& m = graph_.modules()[i];
      texts.emplace(number_key(i), (m.external ? "source in " : "module in ") + number_key(m.thread));
      for (std::size_t p = 0; p < m.topic.size(); ++p) {
        if (m.topic[p] == rt::kNone) continue;
        const bool output = m.declaration.ports[p].kind == rt::Declaration::PortKind::output;
        texts.emplace(number_key(i) + "." + number_key(p), (output ? "out " : "in ") + topics_[m.topic[p]].kept.name);
      }
    }
    return texts;
  }

  hal::Status add_channels() {
    Writer& w = writer_->writer();
    std::map<std::string, std::uint16_t, std::less<>> schemas;
    Texts about;  // of the channels that come next
    const auto channel = [&](std::string_view topic, std::string_view schema, std::string_view text, std::uint16_t& id,
                             Packing packing = Packing::packed) -> hal::Status {
      auto known = schemas.find(schema);
      if (known == schemas.end()) {
        auto added = w.add_schema(schema, "ros2msg", text);
        if (!added) return added.error();
        known = schemas.emplace(schema, *added).first;
      }
      auto added = w.add_channel(topic, "cdr", known->second, about, packing);
      if (!added) return added.error();
      id = *added;
      return {};
    };
    const auto of_record = [&](std::string_view topic, const RecordSchema& schema, std::uint16_t& id) {
      return channel(topic, schema.name, schema.text, id);
    };
    if (auto s = of_record(kStepsTopic, step_batch_schema(), steps_channel_); !s) return s;
    if (auto s = of_record(kRequestsTopic, request_schema(), requests_channel_); !s) return s;
    if (auto s = of_record(kStatesTopic, state_schema(), states_channel_); !s) return s;
    for (Topic& t : topics_) {
      if (!t.kept.wanted) continue;
      about.clear();
      if (t.kept.rate_hz > 0) about["rate_hz"] = rt::format_number(t.kept.rate_hz);
      const msg::TypeInfo& type = *t.about->type;
      if (!type.has_bulk()) {
        if (auto s = channel(t.about->name, msg::ros2_name(type), msg::ros2msg_schema(type), t.channel); !s) return s;
        continue;
      }
      const RecordSchema& image = image_schema();
      if (auto s = channel(t.about->name, image.name, image.text, t.channel, Packing::plain); !s) return s;
      if (auto s = of_record(t.about->name + std::string(kHeadSuffix), image_head_schema(), t.head_channel); !s)
        return s;
    }
    return {};
  }

  Stamps stamps(std::uint32_t sequence, rt::Time log, rt::Time publish) const {
    const auto in_file = [this](rt::Time t) {
      const std::int64_t ns = t.ns + description_.unix_ns;
      return static_cast<std::uint64_t>(std::max(ns, std::int64_t{0}));
    };
    return {sequence, in_file(log), in_file(publish)};
  }

  bool note(const hal::Status& written) {
    if (!written && trouble_) trouble_ = written.error();
    return written.has_value();
  }

  // ---- what the log tells

  void step(const LoggedStep& s) override {
    now_ = std::max(now_, s.completed);
    ++entries_[s.thread];
    for (const LoggedStep::Output& out : s.outputs) {
      Topic& topic = topics_[graph_.modules()[s.module].topic[out.port]];
      if (topic.newest && topic.kept.wanted && topic.kept.rate_hz == 0 && out.first != *topic.newest + 1)
        topic.kept.lost.add(out.first - *topic.newest - 1, s.completed);  // of steps that were lost
      topic.newest = out.first + out.count - 1;
      for (std::uint32_t i = 0; i < out.count; ++i)
        if (topic.kept.wanted) message(topic, out.first + i, s.completed);
    }
    StepBatch& batch = batches_[s.thread];
    batch.add(s);
    if (batch.bytes().size() >= kBatchBytes || s.completed - batch.first() >= kBatchAge) flush_batch(s.thread);
  }

  void request(const LoggedRequest& r) override {
    ++entries_[r.request.thread];
    flush_batch(r.request.thread);  // so that the file has them in their order
    encode(scratch_, r);
    if (!note(writer_->write(requests_channel_, stamps(0, r.now, r.now), scratch_.bytes())))
      lost_entries_[r.request.thread].add(1, r.now);
  }

  /// One that cannot be written costs nothing but a place to begin at; its number in the log is a gap all the same.
  void state(const LoggedState& s) override {
    ++entries_[s.thread];
    flush_batch(s.thread);
    encode(scratch_, s, layouts_[s.module]);
    if (!note(writer_->write(states_channel_, stamps(0, s.completed, s.completed), scratch_.bytes())))
      lost_entries_[s.thread].add(1, s.completed);
  }

  void lost(std::uint32_t thread, std::uint64_t entries) override {
    entries_[thread] += entries;
    lost_entries_[thread].add(entries, now_);
  }

  void flush_batch(std::uint32_t thread) {
    StepBatch& batch = batches_[thread];
    if (batch.empty()) return;
    if (!note(writer_->write(steps_channel_, stamps(0, batch.first(), batch.first()), batch.bytes())))
      lost_entries_[thread].add(batch.count(), batch.first());
    batch.clear();
  }

  void message(Topic& topic, std::uint32_t sequence, rt::Time at) {
    if (topic.kept.rate_hz > 0 && !due(topic.next, topic.kept.rate_hz, at)) return;
    const rt::SlotHeader* slot = topic.reader->pin(sequence);
    const bool written = slot && note(topic.about->type->has_bulk() ? write_image(topic, *slot) : write(topic, *slot));
    if (slot) topic.reader->unpin();
    if (!written) topic.kept.lost.add(1, at);
  }

  hal::Status write(Topic& topic, const rt::SlotHeader& slot) {
    const msg::TypeInfo& type = *topic.about->type;
    scratch_.resize(msg::cdr_size(type, slot.message()));
    msg::cdr_encode(type, slot.message(), {reinterpret_cast<std::uint8_t*>(scratch_.data()), scratch_.size()});
    return writer_->write(topic.channel, stamps(slot.sequence, slot.published, slot.stamp), scratch_.bytes());
  }

  hal::Status write_image(Topic& topic, const rt::SlotHeader& slot) {
    const auto& image = *static_cast<const msg::Image*>(slot.message());
    const std::span<const std::byte> pixels = std::as_bytes(std::span(image.pixels(), image.bulk_used()));
    bool kept = budget_.take(pixels.size(), slot.published);
    const Stamps when = stamps(slot.sequence, slot.published, slot.stamp);
    if (kept) {
      encode_image_head(scratch_, image, description_.unix_ns, topic.about->name);
      const std::span<const std::byte> parts[] = {scratch_.bytes(), pixels};
      kept = note(writer_->write_parts(topic.channel, when, parts));
    }
    if (!kept) topic.kept.without_pixels.add(1, slot.published);
    encode(scratch_, head_of(image, kept));
    return writer_->write(topic.head_channel, when, scratch_.bytes());
  }

  std::vector<std::string> why_not(const rt::GraphModule& m) const {
    std::vector<const TopicKept*> inputs;
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (m.declaration.ports[p].kind != rt::Declaration::PortKind::output && m.topic[p] != rt::kNone)
        inputs.push_back(&topics_[m.topic[p]].kept);
    return reasons(m.external != nullptr, lost_entries_[m.thread], inputs);
  }

  // ---- the thread

  void follow() {
    while (!stop_.load(std::memory_order_relaxed)) {
      read_all(false);
      note(writer_->writer().tick(stamps(0, now_, now_).log_time));
      os_->sleep_until(os_->now() + options_.poll);
    }
  }
  void stop_thread() {
    stop_.store(true, std::memory_order_relaxed);
    thread_.reset();  // joins
  }
  void read_all(bool last) {
    for (std::uint32_t t = 0; t < log_.threads(); ++t) log_.read(t, *this, last);
  }

  rt::Graph& graph_;
  const Pace pace_;
  const RunDescription description_;
  const RecorderOptions options_;
  StepLog log_;
  Budget budget_;
  std::vector<Topic> topics_;
  std::vector<StepBatch> batches_;      // per thread
  std::vector<Losses> lost_entries_;    // per thread
  std::vector<std::uint64_t> entries_;  // per thread: what its log held, lost ones included
  std::optional<SplitWriter> writer_;
  std::uint16_t steps_channel_ = 0, requests_channel_ = 0, states_channel_ = 0;
  std::vector<std::uint64_t> layouts_;  // per module
  Texts params_;                        // of the start: what changes them is in the file
  Buffer scratch_;
  rt::Time now_;  // the newest that was told
  hal::Os* os_ = nullptr;
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
// A run that failed is the one to look at: its record is completed all the same.
RunRecorder::~RunRecorder() {
  if (!body_->finished()) static_cast<void>(body_->finish());
}
rt::RunObserver& RunRecorder::observer() { return *body_; }
hal::Status RunRecorder::start(hal::Os& os) { return body_->start(os); }
hal::Status RunRecorder::finish() { return body_->finish(); }
std::vector<ModuleVerdict> RunRecorder::verdict() const { return body_->verdict(); }
std::map<std::string, Losses> RunRecorder::lost_messages() const { return body_->lost_messages(); }
std::map<std::string, Losses> RunRecorder::lost_steps() const { return body_->lost_steps(); }
unsigned RunRecorder::files() const { return body_->parts(); }
const hal::Status& RunRecorder::trouble() const { return body_->trouble_; }

}  // namespace sinew::record
