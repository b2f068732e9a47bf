// topic list, info, echo, hz of a recorded file.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>

#include "apps/bag/bag_file.hpp"
#include "apps/bag/bag_message.hpp"
#include "apps/command/command.hpp"
#include "apps/live/topic_options.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/process.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

struct FileTopic {
  std::string name, type, writer, thread;  // the last two: only of a run of Sinew
  std::uint16_t channel = 0, schema = 0;
  std::uint64_t messages = 0;
  double rate_hz = 0;
};

/// The topics of a recorded run, or of any other file; without the recorder's own channels (steps, heads of images).
class RecordedTopics {
 public:
  explicit RecordedTopics(record::Reader& reader) : reader_(reader) {
    const auto run = read_metadata(reader, "sinew.run");
    if (const auto offset = run.find("unix_ns"); offset != run.end())
      std::from_chars(offset->second.data(), offset->second.data() + offset->second.size(), unix_ns_);
    for (const auto& entry : reader.channels())
      if (run.empty() || !is_record(entry.second.topic)) topics_.push_back(make(entry.second));
    if (!run.empty()) find_writers();
    std::sort(topics_.begin(), topics_.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  }
  const std::vector<FileTopic>& all() const { return topics_; }
  /// Null after printing why.
  const FileTopic* find(const std::string& file, const std::string& name) const {
    std::string known;
    std::vector<std::string> names;
    for (const FileTopic& t : topics_) {
      if (t.name == name) return &t;
      known += " " + t.name, names.push_back(t.name);
    }
    fail(file + ": no topic " + name + "; it has" + known + hal::did_you_mean(name, names));
    return nullptr;
  }
  /// On the clock of the robot; of other files: the log time itself.
  std::int64_t published_ns(const record::Message& m) const {
    return static_cast<std::int64_t>(m.stamps.log_time) - unix_ns_;
  }

 private:
  static bool is_record(const std::string& topic) {
    return topic == record::kStepsTopic || topic == record::kRequestsTopic || topic == record::kStatesTopic ||
           topic.ends_with(record::kHeadSuffix);
  }
  FileTopic make(const record::Channel& channel) const {
    FileTopic t{
        .name = channel.topic, .type = "", .writer = "", .thread = "", .channel = channel.id, .schema = channel.schema};
    if (const auto schema = reader_.schemas().find(channel.schema); schema != reader_.schemas().end())
      t.type = schema->second.name;
    if (const auto& all = reader_.statistics())
      if (const auto n = all->channel_messages.find(channel.id); n != all->channel_messages.end())
        t.messages = n->second;
    t.rate_hz = channel_rate_hz(reader_, channel);
    return t;
  }
  /// The writer of a topic is the module in its name; its thread is in "sinew.graph": module "007" has "module in 002".
  void find_writers() {
    const auto graph = read_metadata(reader_, "sinew.graph"), threads = read_metadata(reader_, "sinew.threads");
    for (const auto& [number, module] : read_metadata(reader_, "sinew.modules"))
      for (FileTopic& t : topics_) {
        if (t.name.substr(0, t.name.rfind('.')) != module) continue;
        t.writer = module;
        const auto says = graph.find(number);
        if (says == graph.end()) continue;
        const auto thread = threads.find(says->second.substr(says->second.rfind(' ') + 1));
        if (thread != threads.end()) t.thread = thread->second;
      }
  }

  record::Reader& reader_;
  std::int64_t unix_ns_ = 0;
  std::vector<FileTopic> topics_;
};

std::string or_dash(const std::string& text) { return text.empty() ? "-" : text; }
std::string rate_text(double hz) { return hz > 0 ? fmt::format("{:.4g} Hz", hz) : "-"; }

Json to_json(const FileTopic& t) {
  return {{"name", t.name},     {"type", t.type},         {"writer", t.writer},
          {"thread", t.thread}, {"messages", t.messages}, {"rate_hz", t.rate_hz}};
}

}  // namespace

int list_topics_of_file(const TopicListOptions& options) {
  Progress progress("reading");
  const auto reader = open_recording(options.file, progress);
  if (!reader) return kNotBegun;
  const RecordedTopics topics(*reader);
  if (options.json) {
    Json all = Json::array();
    for (const FileTopic& t : topics.all()) all.push_back(to_json(t));
    std::printf("%s", to_line({{"topics", all}}).c_str());
    return kDone;
  }
  std::string out = fmt::format("{:<24} {:<32} {:<14} {:<12} {:>9} {:>9}\n", "topic", "message", "writer", "thread",
                                "messages", "rate");
  for (const FileTopic& t : topics.all())
    out += fmt::format("{:<24} {:<32} {:<14} {:<12} {:>9} {:>9}\n", t.name, or_dash(t.type), or_dash(t.writer),
                       or_dash(t.thread), t.messages, rate_text(t.rate_hz));
  std::printf("%s", out.c_str());
  return kDone;
}

int topic_info_of_file(const TopicOptions& options) {
  Progress progress("reading");
  const auto reader = open_recording(options.file, progress);
  if (!reader) return kNotBegun;
  const RecordedTopics topics(*reader);
  const FileTopic* const t = topics.find(options.file, options.topic);
  if (!t) return kNotBegun;
  const auto schema = reader->schemas().find(t->schema);
  const std::string text = schema == reader->schemas().end() ? "" : schema->second.data;
  if (options.json) {
    Json info = to_json(*t);
    info["definition"] = text;
    std::printf("%s", to_line(info).c_str());
    return kDone;
  }
  std::printf("topic     %s\nwriter    %s in thread %s\nmessages  %llu, rate %s\n%s:\n%s\n", t->name.c_str(),
              or_dash(t->writer).c_str(), or_dash(t->thread).c_str(), static_cast<unsigned long long>(t->messages),
              rate_text(t->rate_hz).c_str(), or_dash(t->type).c_str(), text.c_str());
  return kDone;
}

int echo_file(const EchoOptions& options) {
  Progress progress("reading", !hal::output_is_terminal());
  const auto reader = open_recording(options.file, progress);
  if (!reader) return kNotBegun;
  const RecordedTopics topics(*reader);
  if (!topics.find(options.file, options.topic)) return kNotBegun;
  BagMessages texts(*reader);
  std::string line;
  std::uint64_t n = 0;
  bool has_field = true;
  const bool good = each_message(*reader, {.topics = {options.topic}}, [&](const record::Message& m) {
    line.clear();
    if (!texts.append_json(m, line)) return true;  // that was said
    const std::string text = echo_text(options, Json::parse(line, nullptr, false), texts.schema(*m.channel),
                                       m.stamps.sequence, topics.published_ns(m));
    has_field = !text.empty();
    std::fwrite(text.data(), 1, text.size(), stdout);
    return has_field && (++n, options.count == 0 || n < options.count);
  });
  if (!has_field) return kNotBegun;
  return std::fflush(stdout) == 0 && good && texts.unknown() == 0 ? kDone : kFailed;
}

int hz_of_file(const HzOptions& options) {
  Progress progress("reading");
  const auto reader = open_recording(options.file, progress);
  if (!reader) return kNotBegun;
  const RecordedTopics topics(*reader);
  if (!topics.find(options.file, options.topic)) return kNotBegun;
  RateMeter meter;
  const bool good = each_message(*reader, {.topics = {options.topic}}, [&](const record::Message& m) {
    meter.add(m.stamps.sequence, rt::Time{topics.published_ns(m)});
    return true;
  });
  const TopicRate rate = meter.result();
  print_rate(options, rate);
  if (rate.messages == 0) return fail(options.file + ": no message of " + options.topic, kFailed);
  if (rate.messages == 1) return fail(options.file + ": one message of " + options.topic + ": no rate", kFailed);
  return good ? kDone : kFailed;
}

}  // namespace sinew::app
