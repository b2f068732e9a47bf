#include "client/robot.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "hal/did_you_mean.hpp"
#include "hal/linux/shared_memory.hpp"
#include "hal/platform.hpp"
#include "tap/frames.hpp"

namespace sinew::client {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

constexpr int kTries = 8;  // of a reader that the writer overtakes

/// The codes of the C interface are those of hal::Errc, counted from 1, and one more.
constexpr int code_of(hal::Errc code) { return static_cast<int>(code) + 1; }
static_assert(code_of(hal::Errc::not_found) == SINEW_NOT_FOUND && code_of(hal::Errc::busy) == SINEW_BUSY &&
              code_of(hal::Errc::denied) == SINEW_DENIED && code_of(hal::Errc::not_supported) == SINEW_NOT_SUPPORTED &&
              code_of(hal::Errc::bad_argument) == SINEW_BAD_ARGUMENT &&
              code_of(hal::Errc::bad_data) == SINEW_BAD_DATA && code_of(hal::Errc::closed) == SINEW_CLOSED &&
              code_of(hal::Errc::timeout) == SINEW_TIMEOUT &&
              code_of(hal::Errc::out_of_memory) == SINEW_OUT_OF_MEMORY && code_of(hal::Errc::io) == SINEW_IO);

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

Failure failure(const hal::Error& error, std::string why) {
  if (why.empty()) why = std::string(error.where) + ": " + hal::to_string(error.code);
  return {code_of(error.code), std::move(why)};
}

Robot::Robot(std::string_view name) {
  std::string why;
  auto client = tap::Client::connect(name, why);
  if (!client) throw failure(client.error(), why);
  client_ = std::move(*client);
  const auto reader = client_->reader();
  if (!reader) {
    const bool private_memory = reader.error().code == hal::Errc::not_supported;
    throw failure(reader.error(), client_->robot() + (private_memory ? ": keeps its topics in memory of its own"
                                                                     : std::string(": ") + reader.error().where));
  }
  reader_ = *reader;
  auto topics = describe_topics(ask("topics", "{}"), *reader_);
  if (!topics) throw failure(topics.error());
  topics_ = std::move(*topics);
  follow_.resize(topics_.size());
}

void Robot::check_topic(std::uint32_t topic) const {
  if (topic >= topics_.size())
    throw Failure{SINEW_BAD_ARGUMENT,
                  "topic " + std::to_string(topic) + ": there are " + std::to_string(topics_.size())};
}

std::uint32_t Robot::find_topic(std::string_view name) const {
  std::vector<std::string> names;
  for (std::uint32_t t = 0; t < topics_.size(); ++t) {
    if (topics_[t].name == name) return t;
    names.push_back(topics_[t].name);
  }
  throw Failure{SINEW_NOT_FOUND, "no topic " + std::string(name) + hal::did_you_mean(name, names)};
}

// ---- messages

/// False: it was overwritten meanwhile.
bool Robot::view(const tap::Message& message, sinew_message& out) const {
  const tap::Topic& topic = layout(message.topic);
  out = {};
  out.data = message.data();
  out.message_bytes = topic.message_bytes;
  out.topic = message.topic;
  out.sequence = message.sequence;
  out.stamp_ns = message.header->stamp.ns;
  out.published_ns = message.header->published.ns;
  if (topic.bulk_bytes != 0) {
    out.bulk = message.data() + topic.message_bytes;
    out.bulk_bytes = topic.bulk_bytes;
    if (topic.info && topic.info->has_bulk()) {
      alignas(64) std::array<std::byte, 256> copy;
      if (topic.message_bytes <= copy.size()) {
        std::memcpy(copy.data(), message.data(), topic.message_bytes);
        out.bulk_bytes = std::min(topic.info->bulk_used(copy.data()), topic.bulk_bytes);
      }
    }
  }
  return reader_->holds(message);
}

sinew_message Robot::newest(std::uint32_t topic) const {
  sinew_message out;
  for (int i = 0; i < kTries; ++i) {
    const auto message = reader_->newest(topic);
    if (!message) throw Failure{SINEW_NOT_FOUND, topics_[topic].name + ": no message yet"};
    if (view(*message, out)) return out;
  }
  throw Failure{SINEW_BUSY, topics_[topic].name + ": its writer is faster than this reader"};
}

template <class Look>
sinew_message Robot::wait_for(std::uint32_t topic, hal::Duration timeout, Look&& look) {
  if (!follow_[topic].subscribed) subscribe(topic);
  const hal::Os& os = hal::system_os();
  const hal::Time deadline = timeout < hal::kNever - os.now() ? os.now() + timeout : hal::kNever;
  sinew_message out;
  for (;;) {
    const std::uint32_t bell = client_->bell(topic);
    if (look(out)) return out;
    if (client_->ended()) throw Failure{SINEW_CLOSED, client_->robot() + " ended"};
    if (os.now() >= deadline) throw Failure{SINEW_TIMEOUT, topics_[topic].name + ": no new message in time"};
    client_->wait(topic, bell, deadline);
    if (look(out)) return out;  // before anything else: each line that is not in the cache makes the message older
  }
}

sinew_message Robot::wait(std::uint32_t topic, hal::Duration timeout) {
  return wait_for(topic, timeout, [&](sinew_message& out) {
    tap::Cursor& cursor = follow_[topic].cursor;
    const auto message = reader_->newest(topic);
    if (!message || (cursor.started && static_cast<std::int32_t>(message->sequence - cursor.next) < 0)) return false;
    if (!view(*message, out)) return false;
    out.missed = cursor.started ? message->sequence - cursor.next : 0;
    cursor.next = message->sequence + 1, cursor.started = true;
    return true;
  });
}

sinew_message Robot::next(std::uint32_t topic, hal::Duration timeout) {
  return wait_for(topic, timeout, [&](sinew_message& out) {
    tap::Cursor& cursor = follow_[topic].cursor;
    const std::uint64_t lost = cursor.lost;
    const auto message = reader_->next(topic, cursor);
    if (!message) return false;
    if (!view(*message, out)) {
      cursor.next = message->sequence;  // it counts as lost, if it is gone
      return false;
    }
    out.missed = static_cast<std::uint32_t>(cursor.lost - lost);
    return true;
  });
}

void Robot::wake_at_once(std::uint32_t topic, bool on) {
  if (on && !topics_[topic].wakes_outsiders)
    throw Failure{SINEW_NOT_SUPPORTED,
                  topics_[topic].name + ": the robot file does not say wake_outsiders = true for it"};
  follow_[topic].at_once = on;
  if (follow_[topic].subscribed) subscribe(topic);
}

/// This topic and all that are subscribed already: the robot keeps one list for each connection.
void Robot::subscribe(std::uint32_t topic) {
  Json names = Json::array(), at_once = Json::array();
  for (std::uint32_t t = 0; t < follow_.size(); ++t)
    if (follow_[t].subscribed || t == topic) (follow_[t].at_once ? at_once : names).push_back(topics_[t].name);
  Json arguments{{"period_ms", 1}};
  arguments["topics"] = std::move(names);
  if (!at_once.empty()) arguments["at_once"] = std::move(at_once);
  ask("subscribe", dump(arguments));
  check_reply();
  follow_[topic].subscribed = true;
}

bool Robot::holds(const sinew_message& message) const {
  return reader_->holds({message.topic, message.sequence, nullptr});
}

void Robot::copy(const sinew_message& message, std::span<std::byte> into) const {
  const tap::Topic& topic = layout(message.topic);
  const std::size_t bulk = std::min(message.bulk_bytes, topic.bulk_bytes);
  const std::size_t bytes = std::size_t{topic.message_bytes} + bulk;
  if (into.size() < bytes)
    throw Failure{SINEW_BAD_ARGUMENT,
                  "room for " + std::to_string(into.size()) + " bytes of a message of " + std::to_string(bytes)};
  std::memcpy(into.data(), message.data, topic.message_bytes);
  if (bulk != 0) std::memcpy(into.data() + topic.message_bytes, message.bulk, bulk);
  if (!holds(message)) throw Failure{SINEW_OVERWRITTEN, topics_[message.topic].name + ": read too late"};
}

// ---- requests

const std::string& Robot::ask(std::string_view request, std::string_view arguments) {
  reply_.clear();
  auto reply = client_->request(request, arguments);
  if (!reply) throw failure(reply.error());
  return reply_ = std::move(*reply);
}

void Robot::check_reply() const {
  const Json json = Json::parse(reply_, nullptr, false);
  if (!json.is_object()) throw Failure{SINEW_BAD_DATA, "the robot's reply is no JSON object"};
  if (json.value("ok", false)) return;
  const Json error = json.value("error", Json::object());
  const std::string code = error.value("code", ""), why = error.value("why", "");
  for (int c = 0; c <= static_cast<int>(hal::Errc::io); ++c)
    if (code == tap::code_name(static_cast<hal::Errc>(c))) throw Failure{c + 1, why};
  throw Failure{SINEW_BAD_DATA, "the robot refuses without a known reason"};
}

void Robot::now(std::int64_t& now_ns, std::int64_t* offset_ns) {
  const hal::Time before = hal::system_os().now();
  ask("clock", "{}");
  const hal::Time after = hal::system_os().now();
  check_reply();
  const Json json = Json::parse(reply_);
  now_ns = json.at("now_ns").get<std::int64_t>();
  if (!offset_ns) return;
  *offset_ns = json.at("monotonic").get<bool>() ? 0 : now_ns - (before.ns + (after - before).count() / 2);
}

void Robot::get_param(std::string_view module, std::string_view param, sinew_value& value) {
  ask("params", dump({{"module", module}}));
  check_reply();
  const Json json = Json::parse(reply_);
  std::vector<std::string> names;
  for (const Json& p : json.at("params")) {
    names.push_back(p.at("param").get<std::string>());
    if (names.back() != param) continue;
    const Json& v = p.at("value");
    value = {};
    if (v.is_boolean()) {
      value.kind = SINEW_BOOL, value.boolean = v.get<bool>() ? 1 : 0;
    } else if (p.at("type") == "integer") {
      value.kind = SINEW_INTEGER, value.integer = v.get<std::int64_t>();
    } else if (v.is_number()) {
      value.kind = SINEW_NUMBER, value.number = v.get<double>();
    } else {
      text_ = v.is_string() ? v.get<std::string>() : dump(v);
      value.kind = SINEW_TEXT, value.text = text_.c_str();
    }
    return;
  }
  throw Failure{SINEW_NOT_FOUND,
                std::string(module) + " has no parameter " + std::string(param) + hal::did_you_mean(param, names)};
}

void Robot::set_param(std::string_view module, std::string_view param, const sinew_value& value) {
  Json arguments{{"module", module}, {"param", param}};
  switch (value.kind) {
    case SINEW_BOOL:
      arguments["value"] = value.boolean != 0;
      break;
    case SINEW_INTEGER:
      arguments["value"] = value.integer;
      break;
    case SINEW_NUMBER:
      arguments["value"] = value.number;
      break;
    case SINEW_TEXT:
      arguments["value"] = value.text ? value.text : "";
      break;
    default:
      throw Failure{SINEW_BAD_ARGUMENT, "kind of a value: " + std::to_string(value.kind)};
  }
  ask("param.set", dump(arguments));
  check_reply();
}

// ---- messages to the robot

/// One place for the largest message: the robot has copied it before it answers.
void Robot::map_loans() {
  std::size_t bytes = 0;
  for (std::uint32_t t = 0; t < topics_.size(); ++t)
    if (topics_[t].external) bytes = std::max(bytes, std::size_t{layout(t).message_bytes} + layout(t).bulk_bytes);
  auto memory = hal::create_shared_memory("sinew messages", bytes);
  if (!memory) throw failure(memory.error());
  auto reply = client_->request_with_memory("publish.memory", "{}", **memory);
  if (!reply) throw failure(reply.error());
  reply_ = std::move(*reply);
  check_reply();
  loans_ = std::move(*memory);
}

Robot::Loan Robot::loan(std::uint32_t topic) {
  if (!topics_[topic].external)
    throw Failure{SINEW_NOT_SUPPORTED, topics_[topic].name +
                                           " is written by a module of the robot; only topics with "
                                           "writer = \"external\" take messages"};
  if (!loans_) map_loans();
  const tap::Topic& about = layout(topic);
  std::memset(loans_->data(), 0, about.message_bytes);
  loaned_ = topic, has_loan_ = true;
  const std::span place(loans_->data(), std::size_t{about.message_bytes} + about.bulk_bytes);
  return {place.first(about.message_bytes), place.subspan(about.message_bytes)};
}

void Robot::send(std::size_t bulk_bytes, std::int64_t stamp_ns, bool wait) {
  if (!has_loan_) throw Failure{SINEW_BAD_ARGUMENT, "nothing is loaned: sinew_loan() comes first"};
  const tap::Topic& about = layout(loaned_);
  if (bulk_bytes > about.bulk_bytes)
    throw Failure{SINEW_BAD_ARGUMENT, std::to_string(bulk_bytes) + " bytes of pixels: " + about.name +
                                          " has room for " + std::to_string(about.bulk_bytes)};
  Json arguments{{"topic", about.name}, {"offset", 0}, {"bytes", about.message_bytes + bulk_bytes}};
  if (stamp_ns != 0) arguments["stamp_ns"] = stamp_ns;
  if (!wait) arguments["wait"] = false;
  ask("publish.bytes", dump(arguments));
  check_reply();
  has_loan_ = false;
}

}  // namespace sinew::client
