#include "monitor/foxglove/protocol.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "hal/json_depth.hpp"
#include "monitor/foxglove/reply.hpp"

namespace sinew::foxglove {
namespace {

constexpr int kMostDepth = 32;

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Reads members of an object; the first that is wrong is kept.
class Members {
 public:
  explicit Members(const Json& json, std::string& why) : json_(json), why_(why) {}
  bool good() const { return why_.empty(); }

  std::uint32_t number(const char* name) {
    const auto at = find(name);
    if (at && at->is_number_unsigned() && at->get<std::uint64_t>() <= UINT32_MAX) return at->get<std::uint32_t>();
    return fail(name, "an integer from 0 to 4294967295"), 0;
  }
  std::string text(const char* name) {
    const auto at = find(name);
    if (at && at->is_string()) return at->get<std::string>();
    return fail(name, "a text"), std::string();
  }
  std::optional<std::string> optional_text(const char* name) {
    const auto at = find(name);
    if (!at || at->is_null()) return std::nullopt;
    return text(name);
  }
  const Json& list(const char* name) {
    static const Json kNone = Json::array();
    const auto at = find(name);
    if (at && at->is_array()) return *at;
    return fail(name, "a list"), kNone;
  }
  std::vector<std::string> texts(const char* name) {
    std::vector<std::string> all;
    for (const Json& one : list(name)) {
      if (!one.is_string()) return fail(name, "a list of texts"), std::vector<std::string>();
      all.push_back(one.get<std::string>());
    }
    return all;
  }
  std::vector<std::uint32_t> numbers(const char* name) {
    std::vector<std::uint32_t> all;
    for (const Json& one : list(name)) {
      if (!one.is_number_unsigned() || one.get<std::uint64_t>() > UINT32_MAX)
        return fail(name, "a list of integers from 0 to 4294967295"), std::vector<std::uint32_t>();
      all.push_back(one.get<std::uint32_t>());
    }
    return all;
  }
  const Json* find(const char* name) const {
    if (!json_.is_object()) return nullptr;
    const auto at = json_.find(name);
    return at == json_.end() ? nullptr : &*at;
  }
  void fail(const char* name, const char* wanted) {
    if (why_.empty()) why_ = std::string("\"") + name + "\": " + wanted;
  }

 private:
  const Json& json_;
  std::string& why_;
};

std::optional<ClientMessage> parse_json(const Json& json, std::string& why) {
  Members m(json, why);
  const std::string op = m.text("op");
  if (op == "subscribe") {
    Subscribe s;
    for (const Json& one : m.list("subscriptions")) {
      Members of(one, why);
      s.subscriptions.push_back({of.number("id"), of.number("channelId")});
    }
    return s;
  }
  if (op == "unsubscribe") return Unsubscribe{m.numbers("subscriptionIds")};
  if (op == "advertise") {
    ClientAdvertise a;
    for (const Json& one : m.list("channels")) {
      Members of(one, why);
      a.channels.push_back({of.number("id"), of.text("topic"), of.text("encoding")});
    }
    return a;
  }
  if (op == "unadvertise") return ClientUnadvertise{m.numbers("channelIds")};
  if (op == "getParameters") return GetParameters{m.texts("parameterNames"), m.optional_text("id")};
  if (op == "setParameters") {
    SetParameters s;
    for (const Json& one : m.list("parameters")) {
      Members of(one, why);
      const Json* value = of.find("value");
      s.parameters.push_back({of.text("name"), value ? dumped(*value) : "null"});
    }
    s.id = m.optional_text("id");
    return s;
  }
  if (op == "subscribeParameterUpdates") return FollowParameters{true, m.texts("parameterNames")};
  if (op == "unsubscribeParameterUpdates") return FollowParameters{false, m.texts("parameterNames")};
  if (op == "subscribeConnectionGraph") return FollowGraph{true};
  if (op == "unsubscribeConnectionGraph") return FollowGraph{false};
  if (op == "fetchAsset") return FetchAsset{m.number("requestId")};
  if (why.empty()) why = "unknown op \"" + op.substr(0, 40) + "\"";
  return std::nullopt;
}

/// Little-endian numbers of a binary message.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : bytes_(bytes) {}
  bool good() const { return good_; }
  std::uint64_t number(std::size_t size) {
    const std::string_view part = take(size);
    std::uint64_t value = 0;
    for (std::size_t i = part.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(part[i]);
    return value;
  }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::string_view take(std::size_t size) {
    good_ = good_ && size <= bytes_.size();
    if (!good_) return {};
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }
  std::string_view rest() { return take(bytes_.size()); }

 private:
  std::string_view bytes_;
  bool good_ = true;
};

std::optional<ClientMessage> parse_binary(std::string_view bytes, std::string& why) {
  Fields f(bytes);
  std::optional<ClientMessage> message;
  const auto op = static_cast<unsigned>(f.number(1));
  if (op == 1) {
    ClientData d{f.u32(), {}};
    d.payload = f.rest();
    message = d;
  } else if (op == 2) {
    ServiceCall c{f.u32(), f.u32(), {}, {}};
    c.encoding = f.take(f.u32());
    c.payload = f.rest();
    message = std::move(c);
  } else if (op == 3) {
    PlaybackControl p{};
    const auto command = f.number(1);
    p.play = command == 0;
    p.speed = std::bit_cast<float>(f.u32());
    const bool seeks = f.number(1) != 0;
    const std::uint64_t seek_ns = f.number(8);
    if (seeks) p.seek_ns = seek_ns;
    p.request = f.take(f.u32());
    if (f.good() && (command > 1 || !std::isfinite(p.speed))) {
      why = "playback: command 0 or 1, and a finite speed";
      return std::nullopt;
    }
    message = std::move(p);
  } else {
    why = "unknown binary message";
    return std::nullopt;
  }
  if (f.good()) return message;
  why = "a binary message ends too early";
  return std::nullopt;
}

void put(std::vector<std::byte>& to, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) to.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}
void put(std::vector<std::byte>& to, std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  to.insert(to.end(), bytes.begin(), bytes.end());
}

Json timestamp(std::uint64_t ns) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  return {{"sec", ns / kSecond}, {"nsec", ns % kSecond}};
}

Json ends_json(const Ends& ends, const char* member) {
  Json all = Json::array();
  for (const auto& [name, ids] : ends) all.push_back({{"name", name}, {member, ids}});
  return all;
}

}  // namespace

std::optional<ClientMessage> parse(bool binary, std::span<const std::byte> bytes, std::string& why) {
  why.clear();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (binary) return parse_binary(text, why);
  if (hal::is_nested_deeper(text, kMostDepth)) {
    why = "nested too deep";
    return std::nullopt;
  }
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) {
    why = "a JSON object with \"op\"";
    return std::nullopt;
  }
  auto message = parse_json(json, why);
  return why.empty() ? std::move(message) : std::nullopt;
}

std::string server_info(const ServerInfo& info) {
  Json json{{"op", "serverInfo"}, {"name", info.name}, {"capabilities", info.capabilities}};
  json["supportedEncodings"] = {"json"};
  json["metadata"] = Json::object();
  for (const auto& [key, value] : info.metadata) json["metadata"][key] = value;
  json["sessionId"] = info.session_id;
  if (info.data_ns) {
    json["dataStartTime"] = timestamp(info.data_ns->first);
    json["dataEndTime"] = timestamp(info.data_ns->second);
  }
  return dumped(json);
}

std::string status(StatusLevel level, std::string_view message) {
  return dumped({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string advertise(std::span<const ChannelText> channels) {
  Json list = Json::array();
  for (const ChannelText& c : channels)
    list.push_back({{"id", c.id},
                    {"topic", c.topic},
                    {"encoding", c.encoding},
                    {"schemaName", c.schema_name},
                    {"schema", c.schema},
                    {"schemaEncoding", c.schema_encoding}});
  return dumped({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string unadvertise(std::span<const std::uint32_t> ids) {
  return dumped({{"op", "unadvertise"}, {"channelIds", std::vector(ids.begin(), ids.end())}});
}

std::string advertise_services(std::span<const ServiceText> services) {
  const Json json_object{{"encoding", "json"},
                         {"schemaName", "object"},
                         {"schemaEncoding", "jsonschema"},
                         {"schema", R"({"type":"object"})"}};
  Json list = Json::array();
  for (const ServiceText& s : services)
    list.push_back({{"id", s.id},
                    {"name", s.name},
                    {"type", s.type},
                    {"request", json_object},
                    {"response", json_object},
                    {"requestSchema", R"({"type":"object"})"},
                    {"responseSchema", R"({"type":"object"})"}});
  return dumped({{"op", "advertiseServices"}, {"services", std::move(list)}});
}

std::string unadvertise_services(std::span<const std::uint32_t> ids) {
  return dumped({{"op", "unadvertiseServices"}, {"serviceIds", std::vector(ids.begin(), ids.end())}});
}

std::string service_failure(std::uint32_t service, std::uint32_t call, std::string_view why) {
  return dumped({{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", call}, {"message", why}});
}

std::string graph_update(const GraphUpdate& update) {
  return dumped({{"op", "connectionGraphUpdate"},
                 {"publishedTopics", ends_json(update.published, "publisherIds")},
                 {"subscribedTopics", ends_json(update.subscribed, "subscriberIds")},
                 {"advertisedServices", ends_json(update.services, "providerIds")},
                 {"removedTopics", update.removed_topics},
                 {"removedServices", update.removed_services}});
}

std::string parameter_values(std::span<const ParameterText> parameters, const std::optional<std::string>& id) {
  Json list = Json::array();
  for (const ParameterText& p : parameters) {
    Json one{{"name", p.name}, {"value", Json::parse(p.value, nullptr, false)}};
    if (p.is_float) one["type"] = "float64";
    list.push_back(std::move(one));
  }
  Json json{{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (id) json["id"] = *id;
  return dumped(json);
}

std::vector<std::byte> message_head(std::uint32_t subscription, std::uint64_t time_ns) {
  std::vector<std::byte> head;
  head.reserve(13);
  put(head, 1, 1), put(head, subscription, 4), put(head, time_ns, 8);
  return head;
}

std::vector<std::byte> time(std::uint64_t time_ns) {
  std::vector<std::byte> bytes;
  put(bytes, 2, 1), put(bytes, time_ns, 8);
  return bytes;
}

std::vector<std::byte> service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                                        std::string_view payload) {
  std::vector<std::byte> bytes;
  put(bytes, 3, 1), put(bytes, service, 4), put(bytes, call, 4);
  put(bytes, encoding.size(), 4), put(bytes, encoding), put(bytes, payload);
  return bytes;
}

std::vector<std::byte> asset_failure(std::uint32_t request, std::string_view why) {
  std::vector<std::byte> bytes;
  put(bytes, 4, 1), put(bytes, request, 4), put(bytes, 1, 1), put(bytes, why.size(), 4), put(bytes, why);
  return bytes;
}

std::vector<std::byte> playback_state(const PlaybackState& state) {
  std::vector<std::byte> bytes;
  put(bytes, 5, 1), put(bytes, static_cast<std::uint64_t>(state.status), 1), put(bytes, state.time_ns, 8);
  put(bytes, std::bit_cast<std::uint32_t>(state.speed), 4), put(bytes, state.did_seek ? 1 : 0, 1);
  put(bytes, state.request.size(), 4), put(bytes, state.request);
  return bytes;
}

}  // namespace sinew::foxglove
