#include "tap/client.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "hal/linux/shared_memory.hpp"
#include "hal/linux/socket.hpp"

namespace sinew::tap {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

constexpr hal::Duration kPatience = 10s;  // a change is answered after two seconds at the latest

/// "ok" of a reply, as a Status.
hal::Status verdict(const Json& reply) {
  if (reply.value("ok", false)) return {};
  const std::string code = reply.contains("error") ? reply["error"].value("code", "") : "";
  for (int c = 0; c <= static_cast<int>(hal::Errc::io); ++c)
    if (code == code_name(static_cast<hal::Errc>(c))) return hal::Error{static_cast<hal::Errc>(c), "robot"};
  return hal::Error{hal::Errc::bad_data, "robot"};
}

/// The reply as an object; `{}` when it is no object.
Json parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json::object();
}

}  // namespace

hal::Result<std::unique_ptr<Client>> Client::connect(std::string_view robot, std::string& why) {
  const auto found = find_running(robot, why);
  if (!found) return found.error();
  const auto fail = [&why, &found](const hal::Error& e, const char* words) {
    why = "robot \"" + found->robot + "\" (process " + std::to_string(found->pid) + "): " + words;
    return e;
  };
  auto stream = hal::connect_stream("unix:" + found->path, 500ms);  // the robot may be starting
  if (!stream) return fail(stream.error(), "does not answer at its socket");
  auto client = std::make_unique<Client>(std::move(*stream));
  const auto reply = client->request("hello");
  if (!reply) return fail(reply.error(), "closed the connection: too many programs are connected");
  try {
    const Json hello = parsed(*reply);
    if (auto ok = verdict(hello); !ok) return fail(ok.error(), "refuses to talk");
    if (hello.value("version", 0U) != kProtocolVersion)
      return fail({hal::Errc::not_supported, "version"}, "speaks another version");
    client->robot_ = hello.value("robot", "");
    client->pid_ = hello.value("pid", 0);
  } catch (const Json::exception&) {
    return fail({hal::Errc::bad_data, "hello"}, "does not speak this protocol");
  }
  return client;
}

hal::Result<std::string> Client::request(std::string_view name, std::string_view arguments) {
  return ask(name, arguments, nullptr);
}

hal::Result<std::string> Client::request_with_memory(std::string_view name, std::string_view arguments,
                                                     const hal::SharedMemory& memory) {
  return ask(name, arguments, &memory);
}

bool Client::ended() {
  std::array<std::byte, 1> unasked{};
  const auto n = stream_->read_now(unasked);
  return !n || *n != 0;  // a robot that speaks without being asked speaks another protocol
}

hal::Result<std::string> Client::ask(std::string_view name, std::string_view arguments,
                                     const hal::SharedMemory* memory) {
  Json whole = Json::parse(arguments, nullptr, false);
  if (!whole.is_object()) return hal::Error{hal::Errc::bad_argument, "arguments are no object"};
  whole["request"] = name;
  const std::string text = whole.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > kMaxRequestBytes) return hal::Error{hal::Errc::bad_argument, "request is too long"};
  stream_->set_patience(kPatience);
  const auto head = frame_head(text.size());
  if (memory) {
    if (auto sent = stream_->write_with_memory(head, *memory); !sent) return sent.error();
  }
  const std::span<const std::byte> first = memory ? std::span<const std::byte>() : std::span<const std::byte>(head);
  if (auto sent = stream_->write(first, std::as_bytes(std::span(text))); !sent) return sent.error();
  while (!frames_.frame()) {
    const auto n = stream_->read(frames_.room());
    if (!n) return n.error();
    frames_.filled(*n);
    if (frames_.broken()) return hal::Error{hal::Errc::bad_data, "reply"};
  }
  std::string reply(*frames_.frame());
  frames_.drop();
  return reply;
}

hal::Result<std::unique_ptr<hal::SharedMemory>> Client::memory(std::string_view name) {
  stream_->expect_memory();
  const auto reply = request(name);
  if (!reply) return reply.error();
  try {
    if (auto ok = verdict(parsed(*reply)); !ok) return ok.error();
  } catch (const Json::exception&) {
    return hal::Error{hal::Errc::bad_data, "reply"};
  }
  return stream_->take_memory(hal::Stream::MemoryAccess::mapped);
}

hal::Result<const SegmentReader*> Client::reader() {
  if (reader_) return &*reader_;
  auto topics = memory("memory");
  if (!topics) return topics.error();
  auto doorbells = memory("doorbells");
  if (!doorbells) return doorbells.error();
  auto reader = SegmentReader::open({(*topics)->data(), (*topics)->size()});
  if (!reader) return reader.error();
  topics_ = std::move(*topics);
  doorbells_ = std::move(*doorbells);
  reader_.emplace(std::move(*reader));
  return &*reader_;
}

hal::Status Client::subscribe(std::span<const std::string> topics, hal::Duration period) {
  Json arguments{{"period_ms", std::max<std::int64_t>(period / 1ms, 1)}};
  arguments["topics"] = Json::array();
  for (const std::string& t : topics) arguments["topics"].push_back(t);
  const auto reply = request("subscribe", arguments.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (!reply) return reply.error();
  try {
    return verdict(parsed(*reply));
  } catch (const Json::exception&) {
    return hal::Error{hal::Errc::bad_data, "reply"};
  }
}

const hal::WakeWord* Client::bell_word(std::uint32_t topic) const {
  if (!reader_ || topic >= reader_->topics().size()) return nullptr;
  const std::size_t at = std::size_t{reader_->topics()[topic].bell} * sizeof(hal::WakeWord);
  if (at + sizeof(hal::WakeWord) > doorbells_->size()) return nullptr;
  return reinterpret_cast<const hal::WakeWord*>(doorbells_->data() + at);
}

std::uint32_t Client::bell(std::uint32_t topic) const {
  const hal::WakeWord* word = bell_word(topic);
  return word ? word->load(std::memory_order_relaxed) : 0;
}

void Client::wait(std::uint32_t topic, std::uint32_t seen, hal::Time deadline) const {
  if (const hal::WakeWord* word = bell_word(topic)) hal::wait_shared(*word, seen, deadline);
}

void Client::wait_any(std::span<const Heard> heard, const hal::SeenWord& own, hal::Time deadline) const {
  std::vector<hal::SeenWord> words{own};
  for (const Heard& h : heard) {
    const hal::WakeWord* const word = bell_word(h.topic);
    const auto is_same = [word](const hal::SeenWord& w) { return w.word == word; };
    if (word && std::none_of(words.begin(), words.end(), is_same)) words.push_back({word, h.bell});
  }
  hal::wait_any_shared(words, deadline);
}

}  // namespace sinew::tap
