// topic list, info, echo, hz, pub.
#include <fmt/format.h>

#include <cstdio>

#include "apps/bag/field_remark.hpp"
#include "apps/command/number_check.hpp"
#include "apps/live/commands.hpp"
#include "apps/live/live_command.hpp"
#include "apps/live/topic_options.hpp"
#include "apps/live/topic_reader.hpp"
#include "apps/view/graph_text.hpp"
#include "apps/view/message_text.hpp"
#include "apps/view/reference_text.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "math/hash.hpp"
#include "msg/json.hpp"
#include "msg/ros2msg.hpp"
#include "record/ros2_schema.hpp"

namespace sinew::app {
namespace {

struct PubOptions : LiveOptions {
  std::string topic;
  std::string message;
  double rate_hz = 0;  // 0: once
  std::uint64_t count = 0;
};

struct TopicInfoOptions : TopicOptions {
  const rt::ModuleTypes* types = nullptr;
};

rt::Duration seconds(double s) { return rt::Duration{static_cast<std::int64_t>(s * 1e9)}; }

std::string rate_text(const Json& topic) {
  const double hz = topic.value("rate_hz", 0.0);
  return hz > 0 ? fmt::format("{:.4g} Hz", hz) : "-";
}

int list_topics(const TopicListOptions& options) {
  if (!options.file.empty()) return list_topics_of_file(options);
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto reply = robot->ask("topics");
  if (!reply) return kFailed;
  if (options.json) {
    std::printf("%s", to_line({{"topics", reply->at("topics")}}).c_str());
    return kDone;
  }
  std::printf(
      "%s",
      fmt::format("{:<24} {:<18} {:<14} {:<12} {:>9}\n", "topic", "message", "writer", "thread", "planned").c_str());
  for (const Json& t : reply->at("topics"))
    std::printf("%s", fmt::format("{:<24} {:<18} {:<14} {:<12} {:>9}\n", t.value("name", ""), t.value("type", ""),
                                  t.value("external", false) ? "(external)" : t.value("writer", ""),
                                  t.value("thread", ""), rate_text(t))
                          .c_str());
  return kDone;
}

std::string type_text(const Json& types, const std::string& name) {
  const auto type = types.find(name);
  if (type == types.end()) return {};
  std::string out = fmt::format("{}: {}\n", name, type->value("doc", ""));
  for (const Json& f : type->at("fields"))
    out += fmt::format("  {:<20} {:<14} {:<8} {}\n", f.value("name", ""),
                       f.value("type", "") + (f.value("array", false) ? fmt::format("[{}]", f.value("count", 1)) : ""),
                       f.value("unit", ""), f.value("doc", ""));
  return out;
}

int message_info(const msg::TypeInfo& type, bool json) {
  std::printf("%s", json ? to_line(message_json(type)).c_str() : message_text(type).c_str());
  return kDone;
}

int topic_info(const TopicInfoOptions& options) {
  for (const msg::TypeInfo* type : message_types(*options.types))
    if (type->name == options.topic) return message_info(*type, options.json);
  if (!options.file.empty()) return topic_info_of_file(options);
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto reply = robot->ask("topics");
  const auto status = reply ? robot->ask("status") : std::nullopt;
  if (!status) return kFailed;
  for (const Json& t : reply->at("topics")) {
    if (t.value("name", "") != options.topic) continue;
    Json info = t;
    for (const Json& s : status->at("topics"))
      if (s.value("name", "") == options.topic) info.update(s);
    info["fields"] = reply->at("types").at(t.value("type", "")).at("fields");
    if (options.json) {
      std::printf("%s", to_line(info).c_str());
      return kDone;
    }
    std::printf("topic     %s\nwriter    %s in thread %s\nmessages  %s, %s lost to full queues, planned rate %s\n",
                options.topic.c_str(), t.value("writer", "").c_str(), t.value("thread", "").c_str(),
                info.value("messages", Json()).dump().c_str(), info.value("drops", Json()).dump().c_str(),
                rate_text(t).c_str());
    std::printf("kept      the newest %s, for readers outside\n%s", info.value("keep", Json()).dump().c_str(),
                type_text(reply->at("types"), t.value("type", "")).c_str());
    return kDone;
  }
  std::vector<std::string> names;
  for (const Json& t : reply->at("topics")) names.push_back(t.value("name", ""));
  return fail("robot " + robot->name() + ": no topic " + options.topic + "; see `topic list`" +
                  hal::did_you_mean(options.topic, names),
              kFailed);
}

Json message_of(const TopicReader& reader) {
  std::string text;
  msg::JsonOptions form;
  form.bulk_hash = &math::hash64;
  msg::to_json(*reader.topic().info, reader.message(), text, form);
  return Json::parse(text, nullptr, false);
}

int echo(const EchoOptions& options) {
  if (!options.file.empty()) return echo_file(options);
  auto robot = LiveRobot::find(options);
  auto reader = robot ? TopicReader::open(*robot, options.topic) : std::nullopt;
  if (!reader) return kNotBegun;
  if (!reader->topic().known())
    return fail("this program does not know the message " + reader->topic().type +
                " (or knows another version): use the " + "one that runs the robot");
  const msg::TypeInfo& type = *reader->topic().info;
  std::string ignored;  // our own text
  const auto schema = record::Ros2Schema::parse(msg::ros2_name(type), msg::ros2msg_schema(type), ignored);
  hal::Os& os = hal::system_os();
  for (std::uint64_t n = 0; options.count == 0 || n < options.count; ++n) {
    const auto got = reader->next(options.timeout_s > 0 ? os.now() + seconds(options.timeout_s) : hal::kNever);
    if (got == TopicReader::Got::nothing)
      return fail(fmt::format("{}: no message within {} s", options.topic, options.timeout_s), kFailed);
    if (got == TopicReader::Got::end) return hal::stop_requested() ? kDone : kFailed;
    const std::string text = echo_text(options, message_of(*reader), schema ? &*schema : nullptr,
                                       reader->header().sequence, reader->header().published.ns);
    if (text.empty()) return kNotBegun;
    std::printf("%s", text.c_str());
    std::fflush(stdout);
  }
  if (reader->lost() > 0)
    std::fprintf(stderr, "%s: %llu messages came too fast to be shown\n", options.topic.c_str(),
                 static_cast<unsigned long long>(reader->lost()));
  return kDone;
}

int hz(const HzOptions& options) {
  if (!options.file.empty()) return hz_of_file(options);
  auto robot = LiveRobot::find(options);
  auto reader = robot ? TopicReader::open(*robot, options.topic) : std::nullopt;
  if (!reader) return kNotBegun;
  RateMeter meter;
  const hal::Time end = hal::system_os().now() + seconds(options.seconds);
  for (auto got = TopicReader::Got::message; got == TopicReader::Got::message;) {
    got = reader->next(end);
    if (got == TopicReader::Got::message) meter.add(reader->header().sequence, reader->header().published);
    if (hal::system_os().now() >= end) break;
  }
  const TopicRate r = meter.result();
  print_rate(options, r);
  if (r.messages > 1) return kDone;
  // The first message was in the topic before: it may be as old as the run.
  return fail(fmt::format("{}: {} within {} s{}", options.topic, r.messages == 0 ? "no message" : "nothing new",
                          options.seconds, r.messages == 0 ? "" : ", only an old message"),
              kFailed);
}

int pub(const PubOptions& options) {
  const Json message = Json::parse(options.message, nullptr, false);
  if (!message.is_object()) return fail("a message is one JSON object, e.g. '{\"range_m\": 1.5}'");
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  hal::Os& os = hal::system_os();
  const bool repeats = options.count > 0 || options.rate_hz > 0;
  const std::uint64_t count = repeats ? options.count : 1;  // 0: until it is stopped
  const rt::Duration period = options.rate_hz > 0 ? seconds(1 / options.rate_hz) : rt::Duration{};
  hal::Time next = os.now();
  for (std::uint64_t n = 0; (count == 0 || n < count) && !hal::stop_requested(); ++n) {
    os.sleep_until(next);
    next = next + period;
    auto reply = robot->ask("publish", {{"topic", options.topic}, {"message", message}});
    if (!reply) return kFailed;
    reply->erase("ok");
    if (options.json)
      std::printf("%s", to_line(*reply).c_str());
    else if (count == 1)
      std::printf("%s: published to %s in step %s\n", robot->name().c_str(), options.topic.c_str(),
                  reply->value("step", Json()).dump().c_str());
  }
  return kDone;
}

template <class O>
LiveCommand<O> topic_command(CLI::App& topic, CommandContext& context, const char* name, const char* text,
                             int (*run)(const O&), const char* hint = kTopicHint) {
  auto command = live_command(topic, context, name, text, run);
  command.app.add_option("topic", command.options.topic)->required()->type_name(hint);
  return command;
}

template <class O>
void add_file(LiveCommand<O>& command) {
  CLI::Option* const file =
      command.app.add_option("--file", command.options.file, "use this recording instead of a running robot")
          ->type_name(kFileHint);
  file->excludes(command.app.get_option("--robot"))->excludes(command.app.get_option("--wait"));
}

}  // namespace

std::string echo_text(const EchoOptions& options, Json message, const record::Ros2Schema* schema,
                      std::uint32_t sequence, std::int64_t published_ns) {
  if (schema && !options.json) put_names(message, *schema);
  const Json* part = &message;
  std::string why;
  if (!options.field.empty()) part = find_field(message, options.field, why);
  if (!part) {
    fail("--field " + why);
    return std::string();
  }
  if (options.json)
    return to_line({{"topic", options.topic},
                    {"sequence", sequence},
                    {"published_ns", published_ns},
                    {options.field.empty() ? "message" : "value", *part}});
  if (part->is_object()) return indented_text(*part) + "---\n";
  return (part->is_string() ? part->get<std::string>() : part->dump()) + "\n";
}

void print_rate(const HzOptions& options, const TopicRate& r) {
  if (options.json)
    std::printf("%s", to_line({{"topic", options.topic},
                               {"messages", r.messages},
                               {"lost", r.lost},
                               {"rate_hz", r.rate_hz > 0 ? Json(r.rate_hz) : Json(nullptr)},
                               {"interval_p50_ns", r.interval_p50.count()},
                               {"interval_max_ns", r.interval_max.count()},
                               {"jitter_p50_ns", r.jitter_p50.count()},
                               {"jitter_p99_ns", r.jitter_p99.count()}})
                          .c_str());
  else if (r.messages > 1)
    std::printf("%s\n", fmt::format("{}: {:.2f} Hz; interval p50 {} max {}; jitter p50 {} p99 {}; {} messages, {} lost",
                                    options.topic, r.rate_hz, human(r.interval_p50), human(r.interval_max),
                                    human(r.jitter_p50), human(r.jitter_p99), r.messages, r.lost)
                            .c_str());
}

void add_topic_commands(CLI::App& app, CommandContext& context) {
  CLI::App& topic = *app.add_subcommand("topic", "topics and messages of a running robot or a recording");
  topic.require_subcommand(1);
  auto list = live_command(topic, context, "list", "all topics", list_topics);
  add_file(list);
  auto info = topic_command(topic, context, "info", "one topic, or a type of message with its fields", topic_info);
  info.options.types = &context.types;
  add_file(info);

  auto show = topic_command(topic, context, "echo", "print its messages as they come", echo);
  add_file(show);
  show.app.add_option("-n,--count", show.options.count, "stop after N messages; else at Ctrl-C")
      ->check(whole())
      ->type_name("N");
  show.app.add_option("--field", show.options.field, "only this part, e.g. p_world_m.x or value.0")
      ->type_name(kFieldHint);
  show.app.add_option("--timeout", show.options.timeout_s, "give up after so long without a message")
      ->check(number(1e-6))
      ->type_name("S");

  auto measure = topic_command(topic, context, "hz", "its rate and jitter in the robot's time, and losses", hz);
  add_file(measure);
  measure.app.add_option("--seconds", measure.options.seconds, "how long")->check(number(1e-6))->type_name("S");

  auto plot = live_command(topic, context, "plot", "draw fields over some seconds, as SVG or PNG", plot_topics);
  add_plot_options(plot.app, plot.options.plot);
  plot.app.add_option("--seconds", plot.options.seconds, "how long")->check(number(1e-6))->type_name("S");

  auto send = topic_command(topic, context, "pub", "send a message to an external topic", pub, kExternalHint);
  send.app.add_option("message", send.options.message, "one JSON object; what it leaves out has its default")
      ->required()
      ->type_name("JSON");
  send.app.add_option("--rate", send.options.rate_hz, "repeat it so often a second")
      ->check(number(0.001, 150.0))
      ->type_name("HZ");
  send.app.add_option("-n,--count", send.options.count, "send N times; else once, or with --rate until Ctrl-C")
      ->check(whole())
      ->type_name("N");
}

}  // namespace sinew::app
