#include "record/run/run_sink.hpp"

#include <algorithm>

#include "msg/ros2msg.hpp"
#include "rt/graph.hpp"
#include "rt/parameters.hpp"

namespace sinew::record {
namespace {

using PortKind = rt::Declaration::PortKind;

bool is_input(const rt::GraphModule& module, std::size_t port) {
  return module.declaration.ports[port].kind != PortKind::output && module.topic[port] != rt::kNone;
}

/// Also on the raw topic of a driver, which its steps latch.
bool publishes(const rt::GraphModule& module, std::size_t port) {
  const PortKind kind = module.declaration.ports[port].kind;
  return module.topic[port] != rt::kNone && (kind == PortKind::output || kind == PortKind::raw);
}

}  // namespace

std::uint64_t room_for(std::uint64_t bytes) { return bytes + bytes / 2 + 8 * 1024; }

std::string number_key(std::size_t i) {
  std::string text = std::to_string(i);
  return std::string(text.size() < 3 ? 3 - text.size() : 0, '0') + text;
}

bool RunSink::Budget::take(std::size_t bytes, rt::Time now) {
  if (now > last_) left_ = std::min(per_s_, left_ + per_s_ * msg::seconds(now - last_));
  last_ = std::max(last_, now);
  if (static_cast<double>(bytes) > left_) return false;
  left_ -= static_cast<double>(bytes);
  return true;
}

RunSink::RunSink(const rt::Graph& graph, const RunDescription& description, const SinkOptions& options,
                 Beginning beginning)
    : graph_(graph),
      description_(description),
      pixel_room_bytes_(options.pixel_room_bytes),
      beginning_(std::move(beginning)),
      budget_(options.pixel_bytes_per_s, options.pixels_saved),
      lost_entries_(graph.threads().size()),
      entries_(beginning_.midway ? beginning_.entries : std::vector<std::uint64_t>(graph.threads().size())),
      from_(graph.modules().size()),
      state_part_(graph.modules().size()),
      stepped_(graph.modules().size()),
      written_(entries_),
      newest_(beginning_.at) {
  for (const rt::GraphTopic& about : graph.topics()) {
    Topic& t = topics_.emplace_back();
    const auto& some = options.topics;
    t.kept.name = about.name;
    t.kept.wanted = some.empty() || std::find(some.begin(), some.end(), about.name) != some.end();
    if (const auto rate = options.rate_hz.find(about.name); rate != options.rate_hz.end())
      t.kept.rate_hz = rate->second;
    t.is_image = about.type->has_bulk();
  }
  for (const rt::GraphThread& thread : graph.threads())
    threads_.push_back(options.threads.empty() || std::find(options.threads.begin(), options.threads.end(),
                                                            thread.spec.name) != options.threads.end());
  for (const rt::GraphModule& m : graph.modules())
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (publishes(m, p) && !m.external && !threads_[m.thread]) topics_[m.topic[p]].kept.held_only = true;
}

hal::Result<std::unique_ptr<RunSink>> RunSink::open(const rt::Graph& graph, const RunDescription& description,
                                                    SplitWriter::OpenPart open_part, const SinkOptions& options,
                                                    Beginning beginning) {
  std::unique_ptr<RunSink> sink(new RunSink(graph, description, options, std::move(beginning)));
  if (auto opened = sink->open(std::move(open_part), options.files); !opened) return opened.error();
  return sink;
}

hal::Status RunSink::open(SplitWriter::OpenPart open_part, const SplitOptions& options) {
  auto writer = SplitWriter::open(
      std::move(open_part), [this](Writer& w, unsigned part) { return begin_file(w, part); }, options);
  if (!writer) return writer.error();
  writer_.emplace(std::move(*writer));
  if (beginning_.midway) writer_->count_from(stamps(0, beginning_.at, {}).log_time);
  return add_channels();
}

// ---- the file

hal::Status RunSink::begin_file(Writer& w, unsigned part) {
  Texts modules, threads, chains, run = description_.run;
  run["unix_ns"] = std::to_string(description_.unix_ns);
  run["part"] = std::to_string(part);
  if (std::find(threads_.begin(), threads_.end(), false) != threads_.end()) {
    std::string& names = run[std::string(kThreadsKey)];
    for (std::size_t i = 0; i < threads_.size(); ++i)
      if (threads_[i]) names += (names.empty() ? "" : " ") + graph_.threads()[i].spec.name;
  }
  for (std::size_t i = 0; i < graph_.modules().size(); ++i)
    modules.emplace(number_key(i), graph_.modules()[i].spec.name);
  for (std::size_t i = 0; i < graph_.threads().size(); ++i)
    threads.emplace(number_key(i), graph_.threads()[i].spec.name);
  for (std::size_t i = 0; i < graph_.chains().size(); ++i) chains.emplace(number_key(i), graph_.chains()[i].spec.name);
  std::vector<Metadata> all{{"sinew.run", std::move(run)},         {"sinew.modules", std::move(modules)},
                            {"sinew.threads", std::move(threads)}, {"sinew.chains", std::move(chains)},
                            {"sinew.graph", graph_texts()},        {"sinew.params", beginning_.params}};
  if (part > 0) writer_->count_from(stamps(0, newest_, {}).log_time);  // not the messages that put_again() brings
  if (beginning_.midway || part > 0) {
    Texts begin{{"at_ns", std::to_string(newest_.ns)}};
    for (std::size_t i = 0; i < written_.size(); ++i) begin.emplace(number_key(i), std::to_string(written_[i]));
    all.push_back({std::string(kBeginName), std::move(begin)});
  }
  all.insert(all.end(), description_.more.begin(), description_.more.end());
  for (const Metadata& m : all)
    if (auto added = w.add_metadata(m); !added) return added;
  for (const Attachment& a : description_.attachments)
    if (auto added = w.attach(a); !added) return added;
  return {};
}

/// For each module its thread, and for each port its topic.
Texts RunSink::graph_texts() const {
  Texts texts;
  for (std::size_t i = 0; i < graph_.modules().size(); ++i) {
    const rt::GraphModule& m = graph_.modules()[i];
    texts.emplace(number_key(i), (m.external ? "source in " : "module in ") + number_key(m.thread));
    for (std::size_t p = 0; p < m.topic.size(); ++p) {
      if (m.topic[p] == rt::kNone) continue;
      const bool output = m.declaration.ports[p].kind == PortKind::output;
      texts.emplace(number_key(i) + "." + number_key(p), (output ? "out " : "in ") + topics_[m.topic[p]].kept.name);
    }
  }
  return texts;
}

hal::Status RunSink::add_channels() {
  Writer& w = writer_->writer();
  std::map<std::string, std::uint16_t, std::less<>> schemas;
  Texts about;  // the texts of the channels that come next
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
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    Topic& t = topics_[i];
    if (!t.kept.wanted) continue;
    about.clear();
    if (t.kept.rate_hz > 0) about["rate_hz"] = rt::format_number(t.kept.rate_hz);
    if (t.kept.held_only) about["only"] = "held by recorded steps";
    const msg::TypeInfo& type = *graph_.topics()[i].type;
    if (!t.is_image) {
      if (auto s = channel(t.kept.name, msg::ros2_name(type), msg::ros2msg_schema(type), t.channel); !s) return s;
      continue;
    }
    const RecordSchema& image = image_schema();
    if (auto s = channel(t.kept.name, image.name, image.text, t.channel, Packing::plain); !s) return s;
    if (auto s = of_record(t.kept.name + std::string(kHeadSuffix), image_head_schema(), t.head_channel); !s) return s;
  }
  return {};
}

Stamps RunSink::stamps(std::uint32_t sequence, rt::Time log, rt::Time publish) const {
  const auto in_file = [this](rt::Time t) {
    const std::int64_t ns = t.ns + description_.unix_ns;
    return static_cast<std::uint64_t>(std::max(ns, std::int64_t{0}));
  };
  return {sequence, in_file(log), in_file(publish)};
}

bool RunSink::note(const hal::Status& written) {
  if (!written && trouble_) trouble_ = written.error();
  return written.has_value();
}

// ---- what the run reports

bool RunSink::takes(std::uint32_t topic, rt::Time at) {
  Topic& t = topics_[topic];
  return t.kept.wanted && !t.kept.held_only && (t.kept.rate_hz <= 0 || due(t.next, t.kept.rate_hz, at));
}

bool RunSink::takes_held(std::uint32_t topic, std::uint32_t sequence) {
  constexpr std::size_t kMostHeld = 256;  // more than any queue holds
  Topic& t = topics_[topic];
  if (!t.kept.wanted || !t.kept.held_only) return false;
  if (t.held_part != writer_->part()) t.held.clear(), t.held_part = writer_->part();
  if (std::find(t.held.rbegin(), t.held.rend(), sequence) != t.held.rend()) return false;
  if (t.held.size() == kMostHeld) t.held.pop_front();
  t.held.push_back(sequence);
  return true;
}

void RunSink::put(std::uint32_t topic, const SinkMessage& message, rt::Time at) {
  Topic& t = topics_[topic];
  if (!write(t, message)) return t.kept.lost.add(1, at);
  if (!t.first) t.first = message.slot->sequence;
}

void RunSink::put_older(std::uint32_t topic, const SinkMessage& message) {
  Topic& t = topics_[topic];
  const std::uint32_t sequence = message.slot->sequence;
  if (!write(t, message)) return lacks_until(topic, sequence);
  if (!t.first || (t.older && sequence != *t.older + 1)) t.first = sequence;
  t.older = sequence;
}

bool RunSink::write(Topic& topic, const SinkMessage& message) {
  if (topic.is_image) return note(write_image(topic, message));
  const rt::SlotHeader& slot = *message.slot;
  return note(writer_->write(topic.channel, stamps(slot.sequence, slot.published, slot.stamp), message.cdr));
}

hal::Status RunSink::write_image(Topic& topic, const SinkMessage& message) {
  const rt::SlotHeader& slot = *message.slot;
  const auto& image = *static_cast<const msg::Image*>(slot.message());
  const std::span<const std::byte> pixels = std::as_bytes(std::span(image.pixels(), image.bulk_used()));
  ImageHead head = message.head;
  head.has_pixels =
      bytes_at_most() + room_for(pixels.size()) <= pixel_room_bytes_ && budget_.take(pixels.size(), slot.published);
  const Stamps when = stamps(slot.sequence, slot.published, slot.stamp);
  if (head.has_pixels) {
    encode_image_head(scratch_, image, description_.unix_ns, topic.kept.name);
    const std::span<const std::byte> parts[] = {scratch_.bytes(), pixels};
    head.has_pixels = note(writer_->write_parts(topic.channel, when, parts));
  }
  if (!head.has_pixels) topic.kept.without_pixels.add(1, slot.published);
  encode(scratch_, head);
  return writer_->write(topic.head_channel, when, scratch_.bytes());
}

void RunSink::step(const LoggedStep& s) {
  if (!beginning_.midway && beginning_.at.ns == 0) beginning_.at = s.completed;
  ++entries_[s.thread];
  newest_ = std::max(newest_, s.completed);
  stepped_[s.module] = true;
  if (from_[s.module] && !has_inputs(s)) from_[s.module].reset();
  for (const LoggedStep::Output& out : s.outputs) {
    Topic& t = topics_[graph_.modules()[s.module].topic[out.port]];
    if (t.newest && t.kept.wanted && t.kept.rate_hz == 0 && out.first != *t.newest + 1)
      t.kept.lost.add(out.first - *t.newest - 1, s.completed);  // of lost steps
    t.newest = out.first + out.count - 1;
  }
}

/// True if all that it latched was published after the beginning.
bool RunSink::has_inputs(const LoggedStep& s) const {
  const auto before = [](std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) < 0; };
  for (const LoggedStep::Input& in : s.inputs) {
    if (in.sequences.empty()) continue;
    const Topic& t = topics_[graph_.modules()[s.module].topic[in.port]];
    if (t.first && before(in.sequences.front(), *t.first)) return false;
  }
  return true;
}

void RunSink::steps(std::uint32_t thread, const StepBatch& batch) {
  if (!note(writer_->write(steps_channel_, stamps(0, batch.first(), batch.first()), batch.bytes())))
    lost_entries_[thread].add(batch.count(), batch.first());
  written_[thread] += batch.count();
}

void RunSink::request(const LoggedRequest& r, std::span<const std::byte> bytes) {
  ++entries_[r.request.thread];
  if (!note(writer_->write(requests_channel_, stamps(0, r.now, r.now), bytes)))
    lost_entries_[r.request.thread].add(1, r.now);
  ++written_[r.request.thread];
}

/// A state that cannot be written only costs a place to begin at; its number in the log is a gap all the same.
void RunSink::state(const LoggedState& s, std::span<const std::byte> bytes) {
  ++entries_[s.thread];
  const bool is_written = note(writer_->write(states_channel_, stamps(0, s.completed, s.completed), bytes));
  ++written_[s.thread];
  if (!is_written) return lost_entries_[s.thread].add(1, s.completed);
  state_part_[s.module] = writer_->part();
  if (beginning_.midway && !from_[s.module]) from_[s.module] = s.completed;
}

void RunSink::lost(std::uint32_t thread, std::uint64_t entries, rt::Time at) {
  entries_[thread] += entries;
  written_[thread] += entries;
  lost_entries_[thread].add(entries, at);
}

void RunSink::tick(rt::Time now) { note(writer_->writer().tick(stamps(0, now, now).log_time)); }

// ---- the end

hal::Status RunSink::finish(const RunEnd& end) {
  Texts verdicts, from, losses, entries, newest;
  for (const ModuleVerdict& v : verdict()) {
    verdicts.emplace(v.module, to_text(v));
    if (v.from) from.emplace(v.module, std::to_string(v.from->ns));
  }
  for (const auto& [name, lost] : lost_messages()) losses.emplace(name, to_text(lost, "messages"));
  for (const auto& [name, lost] : lost_steps()) losses.emplace("thread " + name, to_text(lost, "steps"));
  for (std::size_t t = 0; t < entries_.size(); ++t) entries.emplace(number_key(t), std::to_string(entries_[t]));
  for (const Topic& t : topics_)
    if (t.newest) newest.emplace(t.kept.name, std::to_string(*t.newest));
  Writer& w = writer_->writer();
  note(w.add_metadata({"sinew.entries", std::move(entries)}));
  note(w.add_metadata({"sinew.newest", std::move(newest)}));
  if (beginning_.midway) note(w.add_metadata({std::string(kFromName), std::move(from)}));
  note(w.add_metadata({"sinew.verdict", std::move(verdicts)}));
  note(w.add_metadata({"sinew.losses", std::move(losses)}));
  if (!end.result.empty()) note(w.add_metadata({std::string(kResultName), end.result}));
  for (const Attachment& a : end.attachments) note(w.attach(a));
  return writer_->finish();
}

std::vector<ModuleVerdict> RunSink::verdict() const {
  std::vector<ModuleVerdict> all;
  for (std::size_t i = 0; i < graph_.modules().size(); ++i) {
    const rt::GraphModule& m = graph_.modules()[i];
    std::vector<const TopicKept*> inputs;
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (is_input(m, p)) inputs.push_back(&topics_[m.topic[p]].kept);
    ModuleVerdict v{m.spec.name, reasons(m.external != nullptr, lost_entries_[m.thread], inputs), {}};
    if (!threads_[m.thread]) v.reasons.assign(1, not_recorded(graph_.threads()[m.thread].spec.name));
    if (beginning_.midway && stepped_[i]) begins_at(v, from_[i]);
    all.push_back(std::move(v));
  }
  return all;
}

std::map<std::string, Losses> RunSink::lost_messages() const {
  std::map<std::string, Losses> lost;
  for (const Topic& t : topics_)
    if (t.kept.lost.count != 0) lost.emplace(t.kept.name, t.kept.lost);
  return lost;
}

std::map<std::string, Losses> RunSink::lost_steps() const {
  std::map<std::string, Losses> lost;
  for (std::size_t t = 0; t < lost_entries_.size(); ++t)
    if (lost_entries_[t].count != 0) lost.emplace(graph_.threads()[t].spec.name, lost_entries_[t]);
  return lost;
}

}  // namespace sinew::record
