#include "tap/answering.hpp"

#include <new>

#include "hal/did_you_mean.hpp"
#include "hal/json_depth.hpp"

namespace sinew::tap {
namespace {

constexpr int kMaxDepth = 32;  // of JSON: deeper than any request

Reply no_shared_memory() { return refuse(hal::Errc::not_supported, "this run keeps its topics in memory of its own"); }

}  // namespace

Reply Answering::answer(std::string_view text, std::uint64_t client, hal::Stream* stream) {
  client_ = client, stream_ = stream;
  const auto garbage = [](const char* why) {
    Reply reply = refuse(hal::Errc::bad_data, why);
    reply.garbage = true;
    return reply;
  };
  if (hal::is_nested_deeper(text, kMaxDepth)) return garbage("a JSON object that is not nested that deeply");
  try {
    const Json request = Json::parse(text, nullptr, false);
    if (!request.is_object()) return garbage("a JSON object");
    const std::string* name = text_of(request, "request");
    if (!name) return garbage("a JSON object with \"request\"");
    Reply answer = reply(*name, request);
    if (const auto id = request.find("id"); id != request.end() && id->is_primitive())
      (answer.change ? answer.change->reply : answer.json)["id"] = *id;
    return answer;
  } catch (const std::bad_alloc&) {
    throw;                             // not the client's fault, and there is no memory to say so
  } catch (const std::exception& e) {  // thrown by the JSON library; our code throws nothing
    return garbage(e.what());
  }
}

Reply Answering::reply(std::string_view name, const Json& request) {
  if (name == "memory") return memory();
  if (name == "doorbells") return doorbells();
  if (name == "subscribe") return subscribe(request);
  if (auto own = reply_to(name, request)) return std::move(*own);
  std::vector<std::string> known = requests();
  known.insert(known.end(), {"memory", "doorbells", "subscribe"});
  return refuse(hal::Errc::not_found,
                "no request \"" + std::string(name) + "\" in this version" + hal::did_you_mean(name, known));
}

void Answering::forget(std::uint64_t client) {
  if (notifier_) notifier_->subscribe(client, {});
}

Reply Answering::memory() const {
  if (!topics_.memory) return no_shared_memory();
  Json json = Json::object();
  json["bytes"] = topics_.memory->size();
  Reply reply = good(json);
  reply.memory = topics_.memory;
  return reply;
}

Reply Answering::doorbells() const {
  if (!notifier_) return no_shared_memory();
  Json json = Json::object();
  json["bytes"] = notifier_->page().size();
  Reply reply = good(json);
  reply.memory = &notifier_->page();
  return reply;
}

/// Where the writers ring no bells, those of `at_once` are rung once a period, as all others.
std::optional<Reply> Answering::add_bells(const Json& names, bool at_once, TopicNotifier::Wish& wish,
                                          Json& bells) const {
  for (const Json& name : names) {
    const auto* text = name.get_ptr<const std::string*>();
    if (!text) return needs(at_once ? "at_once" : "topics", "a list of names");
    std::string why;
    const auto bell = bell_of(*text, why);
    if (!bell) return refuse(hal::Errc::not_found, why);
    if (at_once && !bell->wakes_outsiders)
      return refuse(hal::Errc::not_supported, *text + ": its robot file does not say wake_outsiders = true");
    if (!bells.contains(*text)) (at_once && topics_.bells ? wish.at_once : wish.writers).push_back(bell->writer);
    bells[*text] = bell->writer;
  }
  return std::nullopt;
}

Reply Answering::subscribe(const Json& request) {
  if (!notifier_) return no_shared_memory();
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
  if (auto refusal = add_bells(*names, false, wish, bells)) return *std::move(refusal);
  if (const auto at = request.find("at_once"); at != request.end()) {
    if (!at->is_array()) return needs("at_once", "a list of names");
    if (auto refusal = add_bells(*at, true, wish, bells)) return *std::move(refusal);
  }
  notifier_->subscribe(client_, std::move(wish));
  Json json = Json::object();
  json["bells"] = std::move(bells);
  return good(json);
}

}  // namespace sinew::tap
