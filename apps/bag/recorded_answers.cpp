#include "apps/bag/recorded_answers.hpp"

#include <algorithm>
#include <limits>

#include "hal/did_you_mean.hpp"
#include "hal/linux/run_dir.hpp"
#include "rt/graph_names.hpp"
#include "tap/frames.hpp"
#include "tap/status_json.hpp"

namespace sinew::app {
namespace {

using State = record::Playback::State;

constexpr std::uint64_t kMostSteps = 1'000'000;

const char* state_name(State state) {
  if (state == State::playing) return "playing";
  return state == State::paused ? "paused" : "ended";
}

/// An integer of 64 bits; nothing for anything else.
std::optional<std::int64_t> integer_of(const tap::Json& request, const char* member) {
  const auto at = request.find(member);
  if (at == request.end() || !at->is_number_integer()) return std::nullopt;
  if (at->is_number_unsigned() && at->get<std::uint64_t>() > INT64_MAX) return std::nullopt;
  return at->get<std::int64_t>();
}

}  // namespace

struct RecordedAnswers::Command {
  std::string_view name;
  Reply (RecordedAnswers::*run)(const Json& request);
};

const std::vector<RecordedAnswers::Command>& RecordedAnswers::commands() {
  using A = RecordedAnswers;
  static const std::vector<Command> all{{"hello", &A::hello},
                                        {"topics", &A::topics},
                                        {"status", &A::status},
                                        {"clock", &A::clock},
                                        {"params", &A::params},
                                        {"timeline", &A::timeline},
                                        {"playback", &A::playback},
                                        {"playback.play", &A::play},
                                        {"playback.pause", &A::pause},
                                        {"playback.seek", &A::seek},
                                        {"playback.step", &A::step},
                                        {"playback.speed", &A::speed},
                                        {"zones", &A::refuse_change},
                                        {"param.set", &A::refuse_change},
                                        {"module.enable", &A::refuse_change},
                                        {"module.disable", &A::refuse_change},
                                        {"thread.period", &A::refuse_change},
                                        {"arm", &A::refuse_change},
                                        {"disarm", &A::refuse_change},
                                        {"publish", &A::refuse_change},
                                        {"publish.memory", &A::refuse_change},
                                        {"publish.bytes", &A::refuse_change},
                                        {"record.start", &A::refuse_change},
                                        {"record.stop", &A::refuse_change},
                                        {"record.status", &A::refuse_change},
                                        {"record.snapshot", &A::refuse_change},
                                        {"stop", &A::refuse_change}};
  return all;
}

RecordedAnswers::RecordedAnswers(record::Playback& playback, const record::StepCounts& counts, RecordedAbout about,
                                 Recording recording)
    : Answering({playback.segment(), &playback.memory()}),
      playback_(playback),
      counts_(counts),
      about_(std::move(about)),
      recording_(std::move(recording)),
      spec_(about_.graph ? about_.graph->spec() : rt::GraphSpec{}),
      safety_(playback.segment(), spec_) {}

std::optional<RecordedAnswers::Reply> RecordedAnswers::reply_to(std::string_view name, const Json& request) {
  for (const Command& c : commands())
    if (c.name == name) return (this->*c.run)(request);
  return std::nullopt;
}

std::vector<std::string> RecordedAnswers::requests() const {
  std::vector<std::string> names;
  for (const Command& c : commands()) names.emplace_back(c.name);
  return names;
}

std::optional<std::size_t> RecordedAnswers::find_topic(const std::string& name) const {
  for (std::size_t t = 0; t < playback_.topics().size(); ++t)
    if (playback_.topics()[t].name == name) return t;
  return std::nullopt;
}

std::string RecordedAnswers::no_such_topic(const std::string& name) const {
  for (const auto& topic : recording_.not_shown)
    if (topic.name == name) return "topic " + name + " is not shown: " + topic.why;
  std::vector<std::string> names;
  for (const record::RecordedTopic& topic : playback_.topics()) names.push_back(topic.name);
  return "no topic " + name + hal::did_you_mean(name, names);
}

/// By the attached robot file.
bool RecordedAnswers::wakes_outsiders(const std::string& topic) const {
  return std::any_of(spec_.topics.begin(), spec_.topics.end(),
                     [&](const rt::TopicSpec& t) { return t.name == topic && t.wake_outsiders; });
}

std::optional<RecordedAnswers::Bell> RecordedAnswers::bell_of(const std::string& topic, std::string& why) const {
  if (const auto t = find_topic(topic))
    return Bell{playback_.segment().entry(playback_.topic_id(*t)).writer, wakes_outsiders(topic)};
  why = no_such_topic(topic);
  return std::nullopt;
}

const rt::GraphModule* RecordedAnswers::module_of(const std::string& name) const {
  const std::uint32_t m = about_.graph ? about_.graph->find_module(name) : rt::kNone;
  return m == rt::kNone ? nullptr : &about_.graph->modules()[m];
}

/// Empty: the file does not say.
std::string RecordedAnswers::thread_of(const std::string& module) const {
  for (std::size_t m = 0; m < about_.modules.size(); ++m)
    if (about_.modules[m] == module && about_.thread_of[m] < about_.threads.size())
      return about_.threads[about_.thread_of[m]];
  return {};
}

// ---- requests that look

RecordedAnswers::Reply RecordedAnswers::hello(const Json&) {
  Json failsafes = Json::array(), not_shown = Json::array();
  for (const rt::FailsafeSpec& f : spec_.failsafes) failsafes.push_back(f.name);
  for (const auto& topic : recording_.not_shown) not_shown.push_back({{"name", topic.name}, {"why", topic.why}});
  return tap::good({{"version", tap::kProtocolVersion},
                    {"robot", recording_.name},
                    {"pid", hal::process_id()},
                    {"board", about_.board},
                    {"robot_file", ""},
                    {"virtual_time", about_.virtual_time},
                    {"failsafes", std::move(failsafes)},
                    {"memory", true},
                    {"recording", recording_.path},
                    {"recorded_robot", about_.robot},
                    {"not_shown", std::move(not_shown)}});
}

RecordedAnswers::Reply RecordedAnswers::topics(const Json&) {
  std::vector<tap::TopicAbout> all;
  for (std::size_t t = 0; t < playback_.topics().size(); ++t) {
    const record::RecordedTopic& topic = playback_.topics()[t];
    const rt::TopicEntry& entry = playback_.segment().entry(playback_.topic_id(t));
    const std::string writer = playback_.segment().writer_entry(entry.writer).name;
    all.push_back({topic.name, topic.type, writer, thread_of(writer), topic.image_bytes, entry.keep, topic.rate_hz,
                   false, wakes_outsiders(topic.name), readers_of(topic.name)});
  }
  return tap::good(tap::directory_json(all));
}

/// By the attached robot file, whose graph is not configured.
std::vector<std::string> RecordedAnswers::readers_of(const std::string& topic) const {
  std::vector<std::string> readers;
  if (!about_.graph) return readers;
  for (const rt::GraphModule& module : about_.graph->modules()) {
    const auto reads = [&](const auto& port) { return port.second.value == topic; };
    if (std::any_of(module.spec.in.begin(), module.spec.in.end(), reads)) readers.push_back(module.spec.name);
  }
  return readers;
}

RecordedAnswers::Json RecordedAnswers::threads_json() const {
  Json threads = Json::array();
  for (std::size_t t = 0; t < about_.threads.size(); ++t) {
    const std::uint32_t known = about_.graph ? about_.graph->find_thread(about_.threads[t]) : rt::kNone;
    rt::ThreadSpec spec;
    if (known != rt::kNone) spec = about_.graph->threads()[known].spec;
    spec.name = about_.threads[t];
    std::vector<std::string> modules;
    for (std::size_t m = 0; m < about_.modules.size(); ++m)
      if (about_.thread_of[m] == t) modules.push_back(about_.modules[m]);
    threads.push_back(tap::thread_json(spec, modules, counts_.thread(t)));
  }
  return threads;
}

RecordedAnswers::Json RecordedAnswers::modules_json() const {
  Json modules = Json::array();
  for (std::size_t m = 0; m < about_.modules.size(); ++m) {
    const rt::GraphModule* const known = module_of(about_.modules[m]);
    rt::ModuleSpec spec;
    if (known) spec.type = known->spec.type;
    spec.name = about_.modules[m];
    modules.push_back(tap::module_json(spec, thread_of(spec.name), counts_.module(m)));
  }
  return modules;
}

RecordedAnswers::Reply RecordedAnswers::status(const Json&) {
  Json json = Json::object(), topics = Json::array();
  for (std::size_t t = 0; t < playback_.topics().size(); ++t)
    topics.push_back(tap::topic_json(playback_.topics()[t].name, playback_.stats(t), 0));
  json["threads"] = threads_json();
  json["modules"] = modules_json();
  json["topics"] = std::move(topics);
  json["chains"] = Json::array();
  json["now_ns"] = playback_.status().now.ns;
  if (Json guardian = safety_.json(); !guardian.is_null()) json["guardian"] = std::move(guardian);
  if (outsiders) json["outsiders"] = outsiders();
  return tap::good(json);
}

/// Time that can be paused and turned back is no machine's clock.
RecordedAnswers::Reply RecordedAnswers::clock(const Json&) {
  return tap::good({{"now_ns", playback_.status().now.ns}, {"monotonic", false}});
}

RecordedAnswers::Reply RecordedAnswers::params(const Json& request) {
  std::string only;
  if (request.contains("module")) {
    const std::string* module = tap::text_of(request, "module");
    if (!module) return tap::needs("module", "a module's name");
    if (!module_of(*module)) {
      const bool named = std::find(about_.modules.begin(), about_.modules.end(), *module) != about_.modules.end();
      if (named) return tap::good({{"params", Json::array()}});  // of another version of the program
      return tap::refuse(hal::Errc::not_found,
                         about_.graph ? rt::no_such_module(*about_.graph, *module) : "no module " + *module);
    }
    only = *module;
  }
  Json list = Json::array();
  const auto now = about_.params_at(playback_.status().now);
  const auto start = about_.params_at({std::numeric_limits<std::int64_t>::min()});  // the same ones, before any change
  for (std::size_t p = 0; p < now.size(); ++p)
    if (only.empty() || now[p].module == only)
      list.push_back(tap::param_json(now[p].module, *now[p].declared, {}, now[p].value, start[p].value));
  Json json = Json::object();
  json["params"] = std::move(list);
  return tap::good(json);
}

RecordedAnswers::Reply RecordedAnswers::timeline(const Json& request) {
  std::int64_t last_ms = 1000;
  if (request.contains("last_ms")) {
    last_ms = integer_of(request, "last_ms").value_or(0);
    if (last_ms < 1 || last_ms > 60'000) return tap::needs("last_ms", "an integer from 1 to 60000");
  }
  const auto events = counts_.timeline(playback_.status().now, std::chrono::milliseconds(last_ms));
  tap::TimelineText timeline = tap::timeline_text(about_.threads, about_.modules, events);
  Reply reply = tap::good(timeline.description);
  reply.long_member = std::move(timeline.events);
  return reply;
}

RecordedAnswers::Json RecordedAnswers::playback_json() const {
  const record::Playback::Status status = playback_.status();
  Json problems = Json::array();
  for (const record::FileProblem& p : status.problems) problems.push_back(to_string(p));
  return {{"state", state_name(status.state)}, {"time_ns", status.now.ns},   {"begin_ns", status.begin.ns},
          {"end_ns", status.end.ns},           {"speed", status.speed},      {"loop", status.loop},
          {"messages", status.messages},       {"not_played", status.unfit}, {"without_pixels", status.without_pixels},
          {"problems", std::move(problems)}};
}

RecordedAnswers::Reply RecordedAnswers::playback(const Json&) { return tap::good(playback_json()); }

// ---- requests that change the playback

RecordedAnswers::Reply RecordedAnswers::waits_for(std::uint64_t number) {
  Reply reply = tap::good();
  reply.change = {{}, std::move(reply.json), number};
  return reply;
}

std::optional<RecordedAnswers::Json> RecordedAnswers::settle(const tap::Change& change) {
  if (playback_.done() < *change.number) return std::nullopt;
  Json reply = change.reply;
  reply.update(playback_json());
  return reply;
}

RecordedAnswers::Json RecordedAnswers::still_waiting(const tap::Change& change) const {
  Json reply = change.reply;
  reply.update(tap::refused(hal::Errc::timeout, "accepted, and it takes long: playback tells how far it is"));
  return reply;
}

RecordedAnswers::Reply RecordedAnswers::play(const Json&) { return waits_for(playback_.play()); }
RecordedAnswers::Reply RecordedAnswers::pause(const Json&) { return waits_for(playback_.pause()); }

RecordedAnswers::Reply RecordedAnswers::seek(const Json& request) {
  const record::Playback::Status status = playback_.status();
  const auto time_ns = integer_of(request, "time_ns");
  if (!time_ns || *time_ns < status.begin.ns || *time_ns > status.end.ns) {
    const std::string allowed =
        "an integer from " + std::to_string(status.begin.ns) + " to " + std::to_string(status.end.ns);
    return tap::needs("time_ns", allowed.c_str());
  }
  return waits_for(playback_.seek(rt::Time{*time_ns}));
}

RecordedAnswers::Reply RecordedAnswers::step(const Json& request) {
  if (request.contains("topic")) {
    if (request.contains("messages")) return tap::refuse(hal::Errc::bad_argument, "either \"messages\" or \"topic\"");
    const std::string* name = tap::text_of(request, "topic");
    if (!name) return tap::needs("topic", "a topic's name");
    const auto topic = find_topic(*name);
    if (!topic) return tap::refuse(hal::Errc::not_found, no_such_topic(*name));
    return waits_for(playback_.step_to(*topic));
  }
  std::int64_t messages = 1;
  if (request.contains("messages")) {
    messages = integer_of(request, "messages").value_or(0);
    if (messages < 1 || static_cast<std::uint64_t>(messages) > kMostSteps)
      return tap::needs("messages", "an integer from 1 to 1000000");
  }
  return waits_for(playback_.step(static_cast<std::uint64_t>(messages)));
}

RecordedAnswers::Reply RecordedAnswers::speed(const Json& request) {
  const auto at = request.find("speed");
  const double speed = at != request.end() && at->is_number() ? at->get<double>() : 0;
  if (!(speed >= record::Playback::kSlowest && speed <= record::Playback::kFastest))
    return tap::needs("speed", "a number from 0.01 to 100");
  return waits_for(playback_.set_speed(speed));
}

RecordedAnswers::Reply RecordedAnswers::refuse_change(const Json&) {
  return tap::refuse(hal::Errc::not_supported, "a recorded run: only its playback can be changed");
}

}  // namespace sinew::app
