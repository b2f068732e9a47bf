#pragma once
// What goes over HTTP and WebSockets, for the server and for the client.
#include <cstddef>
#include <cstdint>
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

  std::size_t size() const { return head.size() + (bytes ? bytes->size() : 0) + tail.size(); }
};

/// What a response sends piece by piece, for as long as it has something. All calls come from the server's thread.
class Stream {
 public:
  virtual ~Stream() = default;  // the response ended, or the peer left
  /// The next piece, asked for when the last one has gone to the system; nothing: none is there yet, wake() asks again.
  virtual std::optional<Piece> next() = 0;
  /// There will be nothing more. Before stream_bytes have come: the connection ends.
  virtual bool is_over() const { return false; }
};

using Headers = std::vector<std::pair<std::string, std::string>>;  // names in lower case

struct Response {
  int status = 200;
  std::string media_type{};
  Headers headers{};
  Bytes body{};                                 // null: empty
  std::unique_ptr<Stream> stream{};             // instead of a body
  std::optional<std::uint64_t> stream_bytes{};  // of the whole stream; unknown: the connection ends with it
};
/// A response of plain text, for errors: `why` and a line end.
Response plain(int status, std::string_view why);

/// One WebSocket. All calls come from the server's thread.
class Socket {
 public:
  struct Message {
    bool binary = false;
    Bytes bytes{};                    // null: only the head
    std::vector<std::byte> head{};    // sent before them, of this connection alone
    bool begins = true, ends = true;  // false: a piece of a message, the pieces before or after it come by themselves
  };
  struct Ending {
    std::uint16_t code;  // of RFC 6455
    std::string why;     // for the peer
  };
  virtual ~Socket() = default;  // closed
  /// A whole message. False: it is refused, and the connection closed.
  virtual bool receive(bool binary, std::span<const std::byte> message) = 0;
  /// The next message for the peer, taken when the connection can take one; nothing: wake() asks again.
  virtual std::optional<Message> next() = 0;
  /// The connection ends once next() has nothing; null: it goes on.
  virtual const Ending* ending() const { return nullptr; }
};

}  // namespace sinew::monitor
