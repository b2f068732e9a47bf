#include "tap/answering.hpp"

#include <new>

#include "hal/did_you_mean.hpp"

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

Reply no_shared_memory() { return refuse(hal::Errc::not_supported, "this run keeps its topics in memory of its own"); }

}  // namespace

Reply Answering::answer(std::string_view text, std::uint64_t client) {
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
    Reply answer = reply(*name, request, client);
    if (const auto id = request.find("id"); id != request.end() && id->is_primitive())
      (answer.change ? answer.change->reply : answer.json)["id"] = *id;
    return answer;
  } catch (const std::bad_alloc&) {
    throw;                             // not the client's fault, and there is no memory to say so
  } catch (const std::exception& e) {  // thrown by the JSON library; our code throws nothing
    return garbage(e.what());
  }
}

Reply Answering::reply(std::string_view name, const Json& request, std::uint64_t client) {
  if (name == "memory") return memory();
  if (name == "doorbells") return doorbells();
  if (name == "subscribe") return subscribe(request, client);
  if (auto own = reply_to(name, request)) return std::move(*own);
  std::vector<std::string> known = requests();
  known.insert(known.end(), {"memory", "doorbells", "subscribe"});
  return refuse(hal::Errc::not_found,
                "no request \"" + std::string(name) + "\" in this version" + hal::did_you_mean(name, known));
}

void Answering::forget(std::uint64_t client) {
  if (notifier_) notifier_->subscribe(client, {}, {});
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

Reply Answering::subscribe(const Json& request, std::uint64_t client) {
  if (!notifier_) return no_shared_memory();
  const auto names = request.find("topics");
  if (names == request.end() || !names->is_array()) return needs("topics", "a list of names");
  std::int64_t period_ms = 1;
  if (const auto at = request.find("period_ms"); at != request.end()) {
    if (!at->is_number_integer() || *at < 1 || *at > 1000) return needs("period_ms", "an integer from 1 to 1000");
    period_ms = at->get<std::int64_t>();
  }
  std::vector<rt::WriterId> writers;
  Json bells = Json::object();
  for (const Json& name : *names) {
    const auto* text = name.get_ptr<const std::string*>();
    if (!text) return needs("topics", "a list of names");
    std::string why;
    const auto writer = bell_of(*text, why);
    if (!writer) return refuse(hal::Errc::not_found, why);
    if (!bells.contains(*text)) writers.push_back(*writer);
    bells[*text] = *writer;
  }
  notifier_->subscribe(client, std::move(writers), std::chrono::milliseconds(period_ms));
  Json json = Json::object();
  json["bells"] = std::move(bells);
  return good(json);
}

}  // namespace sinew::tap
