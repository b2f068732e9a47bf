#pragma once
// The messages of the Foxglove WebSocket protocol v1: what a client sends, read from any bytes, and what we send.
// Source:  github.com/foxglove/ws-protocol, docs/spec.md; binary opcodes 3 (client) and 5 (server) and the times of
//          serverInfo: github.com/foxglove/foxglove-sdk, rust/foxglove/src/protocol.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "monitor/http/server.hpp"

namespace sinew::foxglove {

using monitor::Bytes;
using monitor::Link;

inline constexpr std::string_view kSubprotocol = "foxglove.websocket.v1", kSdkSubprotocol = "foxglove.sdk.v1";
inline constexpr std::size_t kMostClientBytes = 256 << 10;  // of one message of a client

// ---- from the client

struct Subscribe {
  struct One {
    std::uint32_t id, channel;
  };
  std::vector<One> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
struct ClientAdvertise {
  struct One {
    std::uint32_t id;
    std::string topic, encoding;
  };
  std::vector<One> channels;
};
struct ClientUnadvertise {
  std::vector<std::uint32_t> ids;
};
struct GetParameters {
  std::vector<std::string> names;  // empty: all
  std::optional<std::string> id;
};
struct SetParameters {
  struct One {
    std::string name, value;  // the value as JSON
  };
  std::vector<One> parameters;
  std::optional<std::string> id;
};
struct FollowParameters {
  bool on;
  std::vector<std::string> names;  // empty: all
};
struct FollowGraph {
  bool on;
};
struct FetchAsset {
  std::uint32_t request;
};
struct ClientData {
  std::uint32_t channel;
  std::string_view payload;  // of the message
};
struct ServiceCall {
  std::uint32_t service, call;
  std::string encoding;
  std::string_view payload;  // of the message
};
struct PlaybackControl {
  bool play;
  float speed;
  std::optional<std::uint64_t> seek_ns;
  std::string request;  // its id
};
using ClientMessage =
    std::variant<Subscribe, Unsubscribe, ClientAdvertise, ClientUnadvertise, GetParameters, SetParameters,
                 FollowParameters, FollowGraph, FetchAsset, ClientData, ServiceCall, PlaybackControl>;

/// Errors:  nothing, with `why`. The message's views point into `bytes`.
std::optional<ClientMessage> parse(bool binary, std::span<const std::byte> bytes, std::string& why);

// ---- from us

struct ServerInfo {
  std::string name, session_id;
  std::vector<std::string> capabilities;
  std::vector<std::pair<std::string, std::string>> metadata;
  std::optional<std::pair<std::uint64_t, std::uint64_t>> data_ns{};  // begin and end, of a file
};
struct ChannelText {
  std::uint32_t id;
  std::string topic, encoding, schema_name, schema, schema_encoding;
};
struct ServiceText {
  std::uint32_t id;
  std::string name, type;
};
/// A topic or service, and who publishes, subscribes or provides it.
using Ends = std::vector<std::pair<std::string, std::vector<std::string>>>;
struct GraphUpdate {
  Ends published, subscribed, services;
  std::vector<std::string> removed_topics, removed_services;
};
enum class StatusLevel : std::uint8_t { info = 0, warning = 1, error = 2 };

std::string server_info(const ServerInfo& info);
std::string status(StatusLevel level, std::string_view message);
std::string advertise(std::span<const ChannelText> channels);
std::string unadvertise(std::span<const std::uint32_t> ids);
std::string advertise_services(std::span<const ServiceText> services);
std::string unadvertise_services(std::span<const std::uint32_t> ids);
std::string service_failure(std::uint32_t service, std::uint32_t call, std::string_view why);
std::string graph_update(const GraphUpdate& update);
struct ParameterText {
  std::string name, value;  // as JSON
  bool is_float = false;    // a float64, also where its value has no fraction
};
std::string parameter_values(std::span<const ParameterText> parameters, const std::optional<std::string>& id);

/// What comes before the payload.
std::vector<std::byte> message_head(std::uint32_t subscription, std::uint64_t time_ns);
std::vector<std::byte> time(std::uint64_t time_ns);
std::vector<std::byte> service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                                        std::string_view payload);
std::vector<std::byte> asset_failure(std::uint32_t request, std::string_view why);

struct PlaybackState {
  enum class Status : std::uint8_t { playing = 0, paused = 1, buffering = 2, ended = 3 };
  Status status = Status::paused;
  std::uint64_t time_ns = 0;
  float speed = 1;
  bool did_seek = false;
  std::string request{};  // that it answers; empty: none
  bool operator==(const PlaybackState&) const = default;
};
std::vector<std::byte> playback_state(const PlaybackState& state);

}  // namespace sinew::foxglove
