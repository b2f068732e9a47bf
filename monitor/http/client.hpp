#pragma once
// A small HTTP/1.1 and WebSocket client in a server's thread, bounded in everything that a peer can do.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "monitor/http/message.hpp"

namespace sinew::monitor {

/// What is asked of another server. Each goes over a connection of its own.
struct Call {
  std::string host{};  // a name or an address of IPv4
  std::uint16_t port = 0;
  bool tls = false;
  std::string method = "GET";
  std::string target = "/";   // path and query as they go over the line, at most kMostTarget bytes
  Headers headers{};          // beside Host and Content-Length
  std::string body{};         // of a POST
  std::string subprotocol{};  // not empty: a WebSocket that speaks it
  std::chrono::seconds patience{
      10};  // from the beginning to the head of the answer, and between pieces of a known length

  static constexpr std::size_t kMostTarget = 1536, kMostHeaders = 4096;  // bytes
};

/// Thread:  the server's, for everything here.
class Client {
 public:
  /// Piece of a message of a WebSocket, or of the body of a response.
  struct Piece {
    std::span<const std::byte> bytes;
    bool binary = false, begins = true, ends = false;  // of a WebSocket's message
  };
  struct Answer {
    int status = 0;                         // 101: the WebSocket is open; any other one ends it
    Headers headers{};                      // those that mean something to a relay; names in lower case
    std::optional<std::uint64_t> length{};  // of the body; nothing: it ends with the connection
  };
  enum class End { whole, lost, distrusted };  // the answer is whole; it is not; the peer's certificate is not believed
  /// None is called before open() has returned, or after the Connection is gone.
  class Listener {
   public:
    virtual ~Listener() = default;
    virtual void answered(const Answer& answer) = 0;
    virtual void received(const Piece& piece) = 0;
    /// The last call. `why`: empty when the answer is whole.
    virtual void ended(End how, const std::string& why) = 0;
  };
  /// Destroyed: the peer is left.
  class Connection {
   public:
    virtual ~Connection() = default;
    /// False: nothing more is read, so that the peer's system stops sending; at most kAhead bytes still come.
    virtual void read(bool wanted) = 0;
    /// To a WebSocket. False: kMostWaiting bytes wait already, or it is over.
    virtual bool send(bool binary, std::span<const std::byte> message) = 0;

    static constexpr std::size_t kMostWaiting = 1 << 20;
    static constexpr std::size_t kAhead = 64 << 10;
  };

  virtual ~Client() = default;
  /// Errors: by Listener::ended(), also that too many connections are open.
  virtual std::unique_ptr<Connection> open(Call call, Listener& listener) = 0;

  /// A WebSocket that has said nothing for so long is asked whether it is there, and left when it does not answer.
  static constexpr std::chrono::seconds kAskAfter{5}, kLeaveAfter{15};
  static constexpr int kWindow = 256 << 10;  // bytes that a peer may have sent and we have not read
};

}  // namespace sinew::monitor
