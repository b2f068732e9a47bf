#include "tap/answers.hpp"

#include <array>
#include <cmath>

#include "hal/linux/run_dir.hpp"
#include "rt/graph_names.hpp"
#include "rt/parameters.hpp"
#include "tap/frames.hpp"
#include "tap/message_reader.hpp"
#include "tap/status_json.hpp"

namespace sinew::tap {
namespace {

std::optional<rt::ParamValue> value_of(const Json& json) {
  if (json.is_boolean()) return rt::ParamValue(json.get<bool>());
  if (json.is_number_unsigned() && json.get<std::uint64_t>() > INT64_MAX) return std::nullopt;
  if (json.is_number_integer()) return rt::ParamValue(json.get<std::int64_t>());
  if (json.is_number()) return rt::ParamValue(json.get<double>());
  if (json.is_string()) return rt::ParamValue(json.get<std::string>());
  return std::nullopt;
}

/// What the robot file, --params or --set gave; else the default.
rt::ParamValue start_of(const rt::GraphModule& module, std::size_t param) {
  const rt::Declaration::Param& p = module.declaration.params[param];
  const auto given = module.spec.params.find(std::string(p.name));
  return given == module.spec.params.end() ? p.default_value : given->second.value;
}

}  // namespace

struct Answers::Command {
  std::string_view name;
  Reply (Answers::*run)(const Json& request);
};

std::span<const Answers::Command> Answers::commands() {
  static constexpr std::array<Command, 21> kCommands{{{"hello", &Answers::hello},
                                                      {"topics", &Answers::topics},
                                                      {"status", &Answers::status},
                                                      {"params", &Answers::params},
                                                      {"clock", &Answers::clock},
                                                      {"timeline", &Answers::timeline},
                                                      {"zones", &Answers::zones},
                                                      {"param.set", &Answers::set_param},
                                                      {"module.enable", &Answers::enable},
                                                      {"module.disable", &Answers::disable},
                                                      {"thread.period", &Answers::set_period},
                                                      {"arm", &Answers::arm},
                                                      {"disarm", &Answers::disarm},
                                                      {"publish", &Answers::publish},
                                                      {"publish.memory", &Answers::publish_memory},
                                                      {"publish.bytes", &Answers::publish_bytes},
                                                      {"record.start", &Answers::record_start},
                                                      {"record.stop", &Answers::record_stop},
                                                      {"record.status", &Answers::record_status},
                                                      {"record.snapshot", &Answers::record_snapshot},
                                                      {"stop", &Answers::stop}}};
  return kCommands;
}

std::vector<std::string> Answers::requests() const {
  std::vector<std::string> names;
  for (const Command& c : commands()) names.emplace_back(c.name);
  return names;
}

std::optional<Reply> Answers::reply_to(std::string_view name, const Json& request) {
  for (const Command& c : commands())
    if (c.name == name) return (this->*c.run)(request);
  return std::nullopt;
}

std::optional<Answers::Bell> Answers::bell_of(const std::string& name, std::string& why) const {
  const std::uint32_t topic = graph_.find_topic(name);
  if (topic != rt::kNone)
    return Bell{graph_.segment().entry(graph_.topic_id(topic)).writer, graph_.topics()[topic].wake_outsiders};
  why = rt::no_such_topic(graph_, name);
  return std::nullopt;
}

Answers::Answers(rt::Graph& graph, rt::Runner& runner, hal::Os& os, Robot robot)
    : Answering({graph.segment(), graph.memory(), graph.bells()}),
      graph_(graph),
      runner_(runner),
      os_(os),
      robot_(std::move(robot)),
      safety_(graph.segment(), graph.spec()),
      team_(graph.segment()) {
  for (const rt::GraphModule& m : graph_.modules()) {
    auto& values = values_.emplace_back();
    for (const auto& p : m.declaration.params) values.push_back(rt::current(p));
  }
}

std::optional<Json> Answers::settle(const Change& change) {
  if (change.number) return settle_recorder_request(change);
  const auto effect = graph_.effect(change.ticket);
  if (!effect) return std::nullopt;
  Json reply = change.reply;
  if (effect->refused) {
    std::string why;
    for (const std::string& reason : safety_.not_ready()) why += (why.empty() ? "" : "; ") + reason;
    reply.update(refused(hal::Errc::denied, why.empty() ? "not ready" : why));
  }
  reply["step"] = effect->step;
  return reply;
}

Json Answers::still_waiting(const Change& change) const {
  Json reply = change.reply;
  if (change.number) {
    reply.update(refused(hal::Errc::timeout, "accepted, and it takes long: record.status tells when it is done"));
    return reply;
  }
  reply["step"] = Json();
  return reply;
}

void Answers::follow() {
  std::size_t waiting = 0;
  for (ParamChange& c : in_flight_) {
    const auto effect = graph_.effect(c.ticket);
    if (!effect)
      std::swap(in_flight_[waiting++], c);
    else if (!effect->refused)
      values_[c.module][c.param] = std::move(c.value);
  }
  in_flight_.erase(in_flight_.begin() + static_cast<std::ptrdiff_t>(waiting), in_flight_.end());
}

void Answers::forget(std::uint64_t client) {
  Answering::forget(client);
  memories_.erase(client);
}

void Answers::set_memory(std::uint64_t client, std::unique_ptr<hal::SharedMemory> memory) {
  memories_[client] = std::move(memory);
}

// ---- requests that look

Reply Answers::hello(const Json&) {
  Json failsafes = Json::array();
  for (const rt::FailsafeSpec& f : graph_.spec().failsafes) failsafes.push_back(f.name);
  return good({{"version", kProtocolVersion},
               {"robot", robot_.name},
               {"pid", hal::process_id()},
               {"board", robot_.board},
               {"robot_file", robot_.robot_file},
               {"virtual_time", robot_.virtual_time},
               {"failsafes", std::move(failsafes)},
               {"memory", graph_.memory() != nullptr}});
}

Reply Answers::topics(const Json&) {
  std::vector<TopicAbout> topics;
  for (std::uint32_t t = 0; t < graph_.topics().size(); ++t) {
    const rt::GraphTopic& topic = graph_.topics()[t];
    const rt::GraphModule& writer = graph_.modules()[topic.writer];
    topics.push_back({topic.name, topic.type, writer.spec.name, graph_.threads()[writer.thread].spec.name,
                      topic.image_bytes, graph_.slots(t).keep, graph_.planned_rate_hz(t), writer.external != nullptr,
                      topic.wake_outsiders, readers_of(graph_, t)});
  }
  return good(directory_json(topics));
}

Json Answers::counters() {
  Json threads = Json::array(), modules = Json::array(), topics = Json::array(), chains = Json::array();
  for (std::uint32_t t = 0; t < graph_.threads().size(); ++t) {
    std::vector<std::string> order;
    for (const std::uint32_t m : graph_.threads()[t].modules) order.push_back(graph_.modules()[m].spec.name);
    threads.push_back(thread_json(graph_.threads()[t].spec, order, runner_.thread_stats(t)));
  }
  for (std::uint32_t m = 0; m < graph_.modules().size(); ++m) {
    const rt::GraphModule& module = graph_.modules()[m];
    modules.push_back(module_json(module.spec, graph_.threads()[module.thread].spec.name, runner_.module_stats(m)));
  }
  for (std::uint32_t t = 0; t < graph_.topics().size(); ++t)
    topics.push_back(topic_json(graph_.topics()[t].name, runner_.topic_stats(t), runner_.topic_drops(t)));
  for (std::uint32_t c = 0; c < graph_.chains().size(); ++c)
    chains.push_back(chain_json(graph_.chains()[c].spec, runner_.chain_stats(c)));
  return {{"threads", std::move(threads)},
          {"modules", std::move(modules)},
          {"topics", std::move(topics)},
          {"chains", std::move(chains)}};
}

Reply Answers::status(const Json&) {
  Json json = counters();
  json["now_ns"] = now().ns;
  if (Json guardian = safety_.json(); !guardian.is_null()) json["guardian"] = std::move(guardian);
  if (const auto team = team_.get()) json["team"] = team_json(*team);
  if (robot_.complaints) json["devices"] = {{"complaints", robot_.complaints()}};
  if (outsiders) json["outsiders"] = outsiders();
  return good(json);
}

Reply Answers::clock(const Json&) {
  const bool monotonic = !robot_.clock || robot_.clock == static_cast<const hal::Clock*>(&os_);
  return good({{"now_ns", now().ns}, {"monotonic", monotonic}});
}

Reply Answers::params(const Json& request) {
  follow();
  std::string_view only;
  if (request.contains("module")) {
    const std::string* module = text_of(request, "module");
    if (!module) return needs("module", "a module's name");
    if (graph_.find_module(*module) == rt::kNone)
      return refuse(hal::Errc::not_found, rt::no_such_module(graph_, *module));
    only = *module;
  }
  Json list = Json::array();
  for (std::size_t m = 0; m < values_.size(); ++m) {
    const rt::GraphModule& module = graph_.modules()[m];
    if (!only.empty() && module.spec.name != only) continue;
    for (std::size_t p = 0; p < values_[m].size(); ++p)
      list.push_back(param_json(module.spec.name, module.declaration.params[p], module.narrowed[p], values_[m][p],
                                start_of(module, p)));
  }
  Json json = Json::object();
  json["params"] = std::move(list);
  return good(json);
}

Reply Answers::timeline(const Json& request) {
  std::int64_t last_ms = 1000;
  if (const auto at = request.find("last_ms"); at != request.end()) {
    if (!at->is_number_integer() || *at < 1 || *at > 60'000) return needs("last_ms", "an integer from 1 to 60000");
    last_ms = at->get<std::int64_t>();
  }
  std::vector<std::string> threads, modules;
  for (const auto& t : graph_.threads()) threads.push_back(t.spec.name);
  for (const auto& m : graph_.modules()) modules.push_back(m.spec.name);
  TimelineText timeline =
      timeline_text(threads, modules, runner_.timeline().snapshot(std::chrono::milliseconds(last_ms)));
  Reply reply = good(timeline.description);
  reply.long_member = std::move(timeline.events);
  return reply;
}

/// Switches zones on or off, for all readers of the time line, from the next cycles on.
Reply Answers::zones(const Json& request) {
  const auto at = request.find("on");
  if (at == request.end() || !at->is_boolean()) return needs("on", "true or false");
  runner_.ask_for_zones(at->get<bool>());
  return good();
}

// ---- requests that change

Reply Answers::set_param(const Json& request) {
  const std::string *module = text_of(request, "module"), *param = text_of(request, "param");
  if (!module) return needs("module", "a module's name");
  if (!param) return needs("param", "a parameter's name");
  const auto at = request.find("value");
  const auto value = at != request.end() ? value_of(*at) : std::nullopt;
  if (!value) return needs("value", "true, false, a number or a text");
  in_flight_.reserve(in_flight_.size() + 1);  // room first: a posted change must be followed
  std::string why;
  const auto ticket = graph_.set_param(*module, *param, *value, &why);
  if (!ticket) return posted(ticket, why, Json::object());
  const std::size_t m = graph_.find_module(*module);
  const auto& params = graph_.modules()[m].declaration.params;
  const auto p = static_cast<std::size_t>(rt::find_param(graph_.modules()[m].declaration, *param) - params.data());
  const bool widened =
      std::holds_alternative<double*>(params[p].target) && std::holds_alternative<std::int64_t>(*value);
  const rt::ParamValue set = widened ? rt::ParamValue(static_cast<double>(std::get<std::int64_t>(*value))) : *value;
  in_flight_.push_back({*ticket, m, p, set});
  return posted(ticket, why, {{"module", *module}, {"param", *param}, {"value", to_json(set)}});
}

/// The reply to a posted change, or to a change refused at once.
Reply Answers::posted(const hal::Result<rt::Ticket>& ticket, const std::string& why, const Json& members) {
  if (!ticket) return refuse(ticket.error().code, why.empty() ? ticket.error().where : why);
  Reply reply = good(members);
  reply.change = {*ticket, std::move(reply.json)};
  return reply;
}

Reply Answers::set_enabled(const Json& request, bool enabled) {
  const std::string* module = text_of(request, "module");
  if (!module) return needs("module", "a module's name");
  std::string why;
  const auto ticket = graph_.set_enabled(*module, enabled, &why);
  return posted(ticket, why, {{"module", *module}, {"enabled", enabled}});
}

Reply Answers::set_period(const Json& request) {
  const std::string* thread = text_of(request, "thread");
  if (!thread) return needs("thread", "a thread's name");
  const auto at = request.find("period_us");
  if (at == request.end() || !at->is_number()) return needs("period_us", "a number");
  const double us = at->get<double>();
  if (!(us > 0 && us < 1e12)) return needs("period_us", "a number from 10 to 3600000000");
  std::string why;
  const auto ticket = graph_.set_period(*thread, hal::Duration{std::llround(us * 1e3)}, &why);
  return posted(ticket, why, {{"thread", *thread}, {"period_us", us}});
}

Reply Answers::arm(const Json&) {
  std::string why;
  const auto ticket = graph_.arm(&why);
  return posted(ticket, why, Json::object());
}

Reply Answers::disarm(const Json&) {
  std::string why;
  const auto ticket = graph_.disarm(&why);
  return posted(ticket, why, Json::object());
}

Reply Answers::publish(const Json& request) {
  const std::string* topic = text_of(request, "topic");
  if (!topic) return needs("topic", "a topic's name");
  const auto message = request.find("message");
  if (message == request.end() || !message->is_object()) return needs("message", "an object");
  const std::uint32_t t = graph_.find_topic(*topic);
  if (t == rt::kNone) return refuse(hal::Errc::not_found, rt::no_such_topic(graph_, *topic));
  const msg::TypeInfo& type = *graph_.topics()[t].type;
  if (type.has_bulk() || type.align > alignof(std::max_align_t))
    return refuse(hal::Errc::not_supported,
                  *topic + " holds " + std::string(type.name) + ": its messages come in with publish.bytes only");
  std::vector<std::max_align_t> room(type.size / sizeof(std::max_align_t) + 1);
  if (const auto wrong = read_message(type, *message, room.data()))
    return refuse(hal::Errc::bad_argument, "\"message\": " + *wrong);
  return post_message(request, *topic, {.bytes = std::as_bytes(std::span(room)).first(type.size)});
}

/// For both ways in: the stamp, the mailbox, and whether the reply waits for the effect.
Reply Answers::post_message(const Json& request, const std::string& topic, const rt::OutsideMessage& message) {
  rt::OutsideMessage stamped = message;
  if (const auto at = request.find("stamp_ns"); at != request.end()) {
    const bool whole = at->is_number_integer() && !(at->is_number_unsigned() && at->get<std::uint64_t>() > INT64_MAX);
    const std::int64_t stamp_ns = whole ? at->get<std::int64_t>() : 0, now_ns = now().ns;
    if (stamp_ns <= 0 || stamp_ns > now_ns)
      return needs("stamp_ns", ("an integer from 1 to the robot's present time, " + std::to_string(now_ns)).c_str());
    stamped.stamp = hal::Time{stamp_ns};
  }
  bool waits = true;
  if (const auto at = request.find("wait"); at != request.end()) {
    if (!at->is_boolean()) return needs("wait", "true or false");
    waits = at->get<bool>();
  }
  std::string why;
  const auto ticket = graph_.publish(topic, stamped, &why);
  if (waits || !ticket) return posted(ticket, why, {{"topic", topic}});
  return good({{"topic", topic}, {"step", Json()}});
}

Reply Answers::publish_memory(const Json&) {
  if (!stream()) return refuse(hal::Errc::not_supported, "this connection brings no memory");
  auto memory = stream()->take_memory(hal::Stream::MemoryAccess::copied);
  if (!memory)
    return refuse(memory.error().code, memory.error().code == hal::Errc::not_found
                                           ? "no memory came with this request, or it is not the first of its kind"
                                           : memory.error().where);
  const std::size_t bytes = (*memory)->size();
  set_memory(client(), std::move(*memory));
  return good({{"bytes", bytes}});
}

Reply Answers::publish_bytes(const Json& request) {
  const auto messages = request.find("messages");
  return messages == request.end() ? publish_one(request) : publish_several(*messages);
}

/// Each by itself: one that is refused does not keep the others.
Reply Answers::publish_several(const Json& messages) {
  if (!messages.is_array() || messages.empty() || messages.size() > kMostBytesAtOnce)
    return needs("messages", ("an array of 1 to " + std::to_string(kMostBytesAtOnce) + " objects").c_str());
  Json refused = Json::array();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    Json one = messages[i].is_object() ? messages[i] : Json::object();
    one["wait"] = false;
    const Reply reply = publish_one(one);
    if (const auto error = reply.json.find("error"); error != reply.json.end())
      refused.push_back({{"at", i}, {"error", *error}});
  }
  const std::size_t accepted = messages.size() - refused.size();
  return good({{"accepted", accepted}, {"refused", std::move(refused)}});
}

Reply Answers::publish_one(const Json& request) {
  const std::string* topic = text_of(request, "topic");
  if (!topic) return needs("topic", "a topic's name");
  const auto memory = memories_.find(client());
  if (memory == memories_.end())
    return refuse(hal::Errc::bad_argument, "publish.memory comes first: this connection has handed over none");
  const auto size_of = [&request](const char* member) -> std::optional<std::size_t> {
    const auto at = request.find(member);
    if (at == request.end() || !at->is_number_unsigned() || at->get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
    return static_cast<std::size_t>(at->get<std::uint64_t>());
  };
  const auto offset = size_of("offset"), bytes = size_of("bytes");
  if (!offset) return needs("offset", "an integer from 0 to 4294967295");
  if (!bytes) return needs("bytes", "an integer from 0 to 4294967295");
  return post_message(request, *topic, {.memory = memory->second.get(), .offset = *offset, .size = *bytes});
}

Reply Answers::enable(const Json& request) { return set_enabled(request, true); }
Reply Answers::disable(const Json& request) { return set_enabled(request, false); }

Reply Answers::ask_recorder(RecordControl::Command command) {
  if (!robot_.record_control)
    return refuse(hal::Errc::not_supported, "this run has no recorder: it was begun without one");
  Reply reply = good();
  reply.change = {{}, std::move(reply.json), robot_.record_control->ask(command)};
  return reply;
}

std::optional<Json> Answers::settle_recorder_request(const Change& change) const {
  const auto answer = robot_.record_control->answer(*change.number);
  if (!answer) return std::nullopt;
  Json reply = change.reply;
  reply.update(answer->refused ? refused(*answer->refused, answer->text) : Json::parse(answer->text, nullptr, false));
  return reply;
}

Reply Answers::stop(const Json&) {
  if (!robot_.stop) return refuse(hal::Errc::not_supported, "this run cannot be stopped from outside");
  robot_.stop();
  return good();
}

}  // namespace sinew::tap
