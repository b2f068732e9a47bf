#include "tap/answers.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <new>

#include "hal/did_you_mean.hpp"
#include "hal/linux/run_dir.hpp"
#include "msg/json.hpp"
#include "rt/graph_names.hpp"
#include "rt/parameters.hpp"
#include "rt/safety_text.hpp"
#include "tap/frames.hpp"
#include "tap/message_reader.hpp"

namespace sinew::tap {
namespace {

constexpr int kMaxDepth = 32;

/// JSON nested deeper than any request; found before anything is built from it.
bool too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

Reply good(const Json& members = Json::object()) {
  Json json = Json::object();
  json["ok"] = true;
  json.update(members);
  return {std::move(json)};
}

Reply refuse(hal::Errc code, const std::string& why) { return {refused(code, why)}; }

/// A member that is a text; null when it is missing or something else.
const std::string* text_of(const Json& request, const char* member) {
  const auto at = request.find(member);
  return at != request.end() ? at->get_ptr<const std::string*>() : nullptr;
}

Reply needs(const char* member, const char* what) {
  return refuse(hal::Errc::bad_argument, std::string("\"") + member + "\": " + what);
}

std::optional<rt::ParamValue> value_of(const Json& json) {
  if (json.is_boolean()) return rt::ParamValue(json.get<bool>());
  if (json.is_number_unsigned() && json.get<std::uint64_t>() > INT64_MAX) return std::nullopt;
  if (json.is_number_integer()) return rt::ParamValue(json.get<std::int64_t>());
  if (json.is_number()) return rt::ParamValue(json.get<double>());
  if (json.is_string()) return rt::ParamValue(json.get<std::string>());
  return std::nullopt;
}

Json to_json(const rt::ParamValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

Json limit(double value) {
  constexpr double kUnbounded = std::numeric_limits<double>::max();
  return value >= kUnbounded || value <= -kUnbounded ? Json() : Json(value);
}

const char* type_name(const rt::Declaration::Param& p) {
  constexpr std::array<const char*, 4> kNames{"bool", "integer", "number", "text"};
  return kNames[p.target.index()];
}

}  // namespace

Json refused(hal::Errc code, const std::string& why) {
  return {{"ok", false}, {"error", {{"code", hal::to_string(code)}, {"why", why}}}};
}

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string to_text(const Reply& reply) {
  std::string text = to_text(reply.json);
  if (reply.long_member.empty()) return text;
  text.reserve(text.size() + 1 + reply.long_member.size());
  text.back() = ',';
  return text.append(reply.long_member).append(1, '}');
}

struct Answers::Command {
  std::string_view name;
  Reply (Answers::*run)(const Json& request);
};

std::span<const Answers::Command> Answers::commands() {
  static constexpr std::array<Command, 24> kCommands{{{"hello", &Answers::hello},
                                                      {"topics", &Answers::topics},
                                                      {"status", &Answers::status},
                                                      {"params", &Answers::params},
                                                      {"clock", &Answers::clock},
                                                      {"memory", &Answers::memory},
                                                      {"doorbells", &Answers::doorbells},
                                                      {"subscribe", &Answers::subscribe},
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

const Answers::Command* Answers::find(std::string_view name) {
  for (const Command& c : commands())
    if (c.name == name) return &c;
  return nullptr;
}

std::string Answers::near_requests(std::string_view name) {
  std::vector<std::string> names;
  for (const Command& c : commands()) names.emplace_back(c.name);
  return hal::did_you_mean(name, names);
}

Answers::Answers(rt::Graph& graph, rt::Runner& runner, hal::Os& os, TopicNotifier* notifier, Robot robot)
    : graph_(graph), runner_(runner), os_(os), notifier_(notifier), robot_(std::move(robot)) {
  for (const rt::GraphModule& m : graph_.modules()) {
    auto& values = values_.emplace_back();
    for (const auto& p : m.declaration.params) values.push_back(rt::current(p));
  }
  const rt::SegmentHeader& segment = graph_.segment().header();
  auto reader =
      SegmentReader::open({reinterpret_cast<const std::byte*>(&segment), static_cast<std::size_t>(segment.bytes)});
  if (!reader) return;
  reader_.emplace(std::move(*reader));
  for (std::uint32_t t = 0; t < reader_->topics().size(); ++t)
    if (reader_->topics()[t].info == &msg::type_info<msg::SafetyState>()) safety_topic_ = t;
}

Reply Answers::answer(std::string_view text, std::uint64_t client, hal::Stream* stream) {
  client_ = client, stream_ = stream;
  const auto garbage = [](const char* why) {
    Reply reply = refuse(hal::Errc::bad_data, why);
    reply.garbage = true;
    return reply;
  };
  if (too_deep(text)) return garbage("a JSON object that is not nested that deeply");
  try {
    const Json request = Json::parse(text, nullptr, false);
    if (!request.is_object()) return garbage("a JSON object");
    const std::string* name = text_of(request, "request");
    if (!name) return garbage("a JSON object with \"request\"");
    const Command* command = find(*name);
    Reply reply =
        command ? (this->*command->run)(request)
                : refuse(hal::Errc::not_found, "no request \"" + *name + "\" in this version" + near_requests(*name));
    if (const auto id = request.find("id"); id != request.end() && id->is_primitive())
      (reply.change ? reply.change->reply : reply.json)["id"] = *id;
    return reply;
  } catch (const std::bad_alloc&) {
    throw;                             // not the client's fault, and there is no memory to say so
  } catch (const std::exception& e) {  // thrown by the JSON library; our code throws nothing
    return garbage(e.what());
  }
}

std::optional<Json> Answers::settle(const Change& change) {
  if (change.recorder_request) return settle_recorder_request(change);
  const auto effect = graph_.effect(change.ticket);
  if (!effect) return std::nullopt;
  Json reply = change.reply;
  if (effect->refused) {
    std::string why;
    for (const std::string& reason : not_ready()) why += (why.empty() ? "" : "; ") + reason;
    reply.update(refused(hal::Errc::denied, why.empty() ? "not ready" : why));
  }
  reply["step"] = effect->step;
  return reply;
}

Json Answers::still_waiting(const Change& change) const {
  Json reply = change.reply;
  if (change.recorder_request) {
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
  if (notifier_) notifier_->subscribe(client, {});
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

Reply Answers::topics(const Json&) { return good(directory_json(graph_)); }

Reply Answers::status(const Json&) {
  Json json = status_json(graph_, runner_);
  json["now_ns"] = now().ns;
  if (Json guardian = guardian_json(); !guardian.is_null()) json["guardian"] = std::move(guardian);
  if (robot_.complaints) json["devices"] = {{"complaints", robot_.complaints()}};
  if (outsiders) json["outsiders"] = outsiders();
  return good(json);
}

Reply Answers::clock(const Json&) {
  const bool monotonic = !robot_.clock || robot_.clock == static_cast<const hal::Clock*>(&os_);
  return good({{"now_ns", now().ns}, {"monotonic", monotonic}});
}

Json Answers::param_json(const rt::GraphModule& module, std::size_t param, const rt::ParamValue& value) const {
  const rt::Declaration::Param& p = module.declaration.params[param];
  const std::optional<rt::ParamRange>& narrowed = module.narrowed[param];
  return {{"module", module.spec.name},
          {"param", p.name},
          {"type", type_name(p)},
          {"value", to_json(value)},
          {"default", to_json(p.default_value)},
          {"unit", p.unit},
          {"min", limit(narrowed ? narrowed->min : p.min)},
          {"max", limit(narrowed ? narrowed->max : p.max)},
          {"doc", p.doc},
          {"allowed", rt::allowed_values(p, narrowed)}};
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
    for (std::size_t p = 0; p < values_[m].size(); ++p) list.push_back(param_json(module, p, values_[m][p]));
  }
  Json json = Json::object();
  json["params"] = std::move(list);
  return good(json);
}

Reply Answers::memory(const Json&) {
  if (!graph_.memory()) return refuse(hal::Errc::not_supported, "this run keeps its topics in memory of its own");
  Json json = Json::object();
  json["bytes"] = graph_.memory()->size();
  Reply reply = good(json);
  reply.memory = graph_.memory();
  return reply;
}

Reply Answers::doorbells(const Json&) {
  if (!notifier_) return refuse(hal::Errc::not_supported, "this run keeps its topics in memory of its own");
  Json json = Json::object();
  json["bytes"] = notifier_->page().size();
  Reply reply = good(json);
  reply.memory = &notifier_->page();
  return reply;
}

Reply Answers::subscribe(const Json& request) {
  if (!notifier_) return refuse(hal::Errc::not_supported, "this run keeps its topics in memory of its own");
  const auto names = request.find("topics");
  if (names == request.end() || !names->is_array()) return needs("topics", "a list of names");
  std::int64_t period_ms = 1;
  if (const auto at = request.find("period_ms"); at != request.end()) {
    if (!at->is_number_integer() || *at < 1 || *at > 1000) return needs("period_ms", "an integer from 1 to 1000");
    period_ms = at->get<std::int64_t>();
  }
  TopicNotifier::Wish wish;
  wish.period = std::chrono::milliseconds(period_ms);
  Json bells = Json::object();
  std::optional<Reply> refusal;
  const auto read = [&](const Json& list, bool at_once) {
    for (const Json& name : list) {
      const auto* text = name.get_ptr<const std::string*>();
      if (!text) return refusal = needs(at_once ? "at_once" : "topics", "a list of names");
      const std::uint32_t topic = graph_.find_topic(*text);
      if (topic == rt::kNone) return refusal = refuse(hal::Errc::not_found, rt::no_such_topic(graph_, *text));
      if (at_once && !graph_.topics()[topic].wake_outsiders)
        return refusal =
                   refuse(hal::Errc::not_supported, *text + ": its robot file does not say wake_outsiders = true");
      const rt::WriterId writer = graph_.segment().entry(graph_.topic_id(topic)).writer;
      if (!bells.contains(*text)) (at_once ? wish.at_once : wish.writers).push_back(writer);
      bells[*text] = writer;
    }
    return refusal;
  };
  read(*names, false);
  if (const auto at = request.find("at_once"); at != request.end() && !refusal) {
    if (!at->is_array()) return needs("at_once", "a list of names");
    read(*at, true);
  }
  if (refusal) return *std::move(refusal);
  notifier_->subscribe(client_, std::move(wish));
  Json json = Json::object();
  json["bells"] = std::move(bells);
  return good(json);
}

Reply Answers::timeline(const Json& request) {
  std::int64_t last_ms = 1000;
  if (const auto at = request.find("last_ms"); at != request.end()) {
    if (!at->is_number_integer() || *at < 1 || *at > 60'000) return needs("last_ms", "an integer from 1 to 60000");
    last_ms = at->get<std::int64_t>();
  }
  TimelineText timeline = timeline_text(graph_, runner_, std::chrono::milliseconds(last_ms));
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

/// The newest message of the guardian's SafetyState, read as an outsider reads it.
std::optional<msg::SafetyState> Answers::safety() const {
  if (!safety_topic_) return std::nullopt;
  std::array<std::byte, sizeof(rt::SlotHeader) + sizeof(msg::SafetyState)> copy;
  for (int i = 0; i < 8; ++i) {
    const auto message = reader_->newest(*safety_topic_);
    if (!message) return std::nullopt;
    if (!reader_->copy(*message, copy)) continue;
    msg::SafetyState state;
    std::memcpy(&state, copy.data() + sizeof(rt::SlotHeader), sizeof state);
    return state;
  }
  return std::nullopt;
}

std::vector<std::string> Answers::not_ready() const {
  const auto state = safety();
  return state ? rt::not_ready(graph_.spec(), *state) : std::vector<std::string>{};
}

Json Answers::guardian_json() const {
  const auto state = safety();
  if (!state) return {};
  std::string text;
  msg::to_json(msg::type_info<msg::SafetyState>(), &*state, text);
  Json json = Json::parse(text, nullptr, false);
  json["reasons"] = rt::not_ready(graph_.spec(), *state);
  return json;
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
  if (!stream_) return refuse(hal::Errc::not_supported, "this connection brings no memory");
  auto memory = stream_->take_memory(hal::Stream::MemoryAccess::copied);
  if (!memory)
    return refuse(memory.error().code, memory.error().code == hal::Errc::not_found
                                           ? "no memory came with this request, or it is not the first of its kind"
                                           : memory.error().where);
  const std::size_t bytes = (*memory)->size();
  set_memory(client_, std::move(*memory));
  return good({{"bytes", bytes}});
}

Reply Answers::publish_bytes(const Json& request) {
  const std::string* topic = text_of(request, "topic");
  if (!topic) return needs("topic", "a topic's name");
  const auto memory = memories_.find(client_);
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
  const auto answer = robot_.record_control->answer(*change.recorder_request);
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
