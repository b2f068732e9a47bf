#pragma once
// A small HTTP/1.1 and WebSocket server, on libwebsockets: one thread, bounded in everything that a peer can ask for.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew::monitor {

/// Bytes that several connections send at the same time.
using Bytes = std::shared_ptr<const std::vector<std::byte>>;
Bytes bytes_of(std::string_view text);

struct Request {
  std::string method;                                        // "GET", "HEAD", "POST", ...
  std::string path;                                          // decoded, begins with '/', has no "." and ".." parts
  std::vector<std::pair<std::string, std::string>> query{};  // decoded, in their order
  std::string host{}, origin{}, authorization{}, if_none_match{}, content_type{},
      accept_encoding{};                  // headers; empty: not sent
  std::string until_ns{}, control_key{};  // x-sinew-until-ns, x-sinew-control
  std::string peer{};                     // numeric address
  std::string body{};
  std::string subprotocol{};  // of a WebSocket: the one of ours that it offered first
  /// The last one of this name; nothing: there is none.
  const std::string* argument(std::string_view name) const;
};

/// Sent in one go: bytes that several connections share, between some of this one's own.
struct Piece {
  std::string head{};
  Bytes bytes{};  // null: none
  std::string tail{};
};

/// What a response sends piece by piece, for as long as it has something. All calls come from the server's thread.
class Stream {
 public:
  virtual ~Stream() = default;  // the response ended, or the peer left
  /// The next piece, asked for when the last one has gone to the system; nothing: none is there yet, wake() asks again.
  virtual std::optional<Piece> next() = 0;
  /// There will be nothing more: the connection ends.
  virtual bool is_over() const { return false; }
};

using Headers = std::vector<std::pair<std::string, std::string>>;  // names in lower case

struct Response {
  int status = 200;
  std::string media_type{};
  Headers headers{};
  Bytes body{};                                 // null: empty
  std::unique_ptr<Stream> stream{};             // instead of a body; the response then ends with the connection
  std::optional<std::uint64_t> stream_bytes{};  // of the whole stream, where they are known
};
/// A response of plain text, for errors: `why` and a line end.
Response plain(int status, std::string_view why);

/// Names one connection, also after it ended; no two have the same.
using ConnectionId = std::uint64_t;

/// What the system knows of a connection, in bytes of TCP since its beginning.
struct Link {
  std::uint64_t acknowledged = 0;             // by the peer's system
  std::uint32_t outstanding = 0, unsent = 0;  // given to the system and not acknowledged; of them not even sent
  std::uint32_t round_trip_us = 0, shortest_round_trip_us = 0;  // smoothed; the shortest of the last minutes
};

/// One WebSocket. All calls come from the server's thread.
class Socket {
 public:
  struct Message {
    bool binary = false;
    Bytes bytes{};                  // null: only the head
    std::vector<std::byte> head{};  // sent before them, of this connection alone
  };
  virtual ~Socket() = default;  // closed
  /// A whole message. False: it is refused, and the connection closed.
  virtual bool receive(bool binary, std::span<const std::byte> message) = 0;
  /// The next message for the peer, taken when the connection can take one; nothing: wake() asks again.
  virtual std::optional<Message> next() = 0;
};

struct ServerOptions {
  std::string address = "127.0.0.1";  // of an interface; "0.0.0.0": all
  std::uint16_t port = 8080;          // 0: any free one
  std::string certificate{}, key{};   // files in PEM; both empty: no TLS
  /// A new connection beyond them replaces one without a request; it is refused where there is none.
  unsigned most_connections = 256, most_per_peer = 64;
  std::size_t most_body_bytes = 64 << 10, most_message_bytes = 8 << 20;  // that a peer sends: requests, WebSocket
  std::chrono::seconds patience{10};        // for a request, and for a peer that takes nothing
  Headers every_response{};                 // sent with each
  std::vector<std::string> subprotocols{};  // of WebSockets; one that offers only others is refused
};

/// Thread:  any calls wake() and post(); the owner everything else.
class Server {
 public:
  /// Answers a request, now or later, once: from any thread. When the peer is gone meanwhile nothing happens. A
  /// response that is never given ends the connection with status 503 when its last copy is destroyed.
  using Reply = std::function<void(Response)>;
  /// Both are called by the server's thread and must not wait.
  using OnRequest = std::function<void(Request request, ConnectionId connection, Reply reply)>;
  /// Accepts a WebSocket; null refuses it with `refusal`.
  using OnSocket =
      std::function<std::unique_ptr<Socket>(const Request& request, ConnectionId connection, Response& refusal)>;

  /// Listens. Errors: null, with `why`: the address, the port, the certificate.
  static std::unique_ptr<Server> open(const ServerOptions& options, OnRequest on_request, OnSocket on_socket,
                                      std::string& why);
  virtual ~Server() = default;

  virtual std::uint16_t port() const = 0;
  /// Serves until stop(). Thread: one, which is then "the server's thread".
  virtual void run() = 0;
  /// Thread: any.
  virtual void stop() = 0;
  /// The connection's Stream or Socket has something new. Thread: any.
  virtual void wake(ConnectionId connection) = 0;
  /// Called by the server's thread, soon. Thread: any.
  virtual void post(std::function<void()> what) = 0;
  /// The same, not before that time has passed. Thread: the server's.
  virtual void after(std::chrono::milliseconds time, std::function<void()> what) = 0;

  /// Of an open connection. Thread: the server's.
  virtual std::optional<Link> link(ConnectionId connection) const = 0;

  struct Counters {
    std::uint64_t accepted = 0, refused_full = 0, refused_peer = 0, made_room = 0, requests = 0, refused_requests = 0,
                  open = 0;
  };
  virtual Counters counters() const = 0;  // Thread: any
};

}  // namespace sinew::monitor
