#pragma once
#include <chrono>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/monitors.hpp"

namespace sinew::monitor {

/// Carries requests and WebSockets below /at/ADDRESS/ to the monitor at that address, and back, so that a page speaks
/// to one origin. It decides nothing: the other monitor sees the token and refuses by itself. What comes back is shown
/// as data only, whatever the other monitor says that it is. A connection holds at most 256 KiB here, and 256 KiB in
/// the system: when its reader takes no more, the other monitor is not read either.
/// Thread:  the server's.
/// Owner:   server, gate and monitors must outlive it.
class Relay {
 public:
  Relay(Server& server, const Gate& gate, const Monitors& monitors);

  static bool has(std::string_view path) { return path.starts_with("/at/"); }
  void answer(const Request& request, ConnectionId connection, const Server::Reply& reply);
  /// As Server::OnSocket. The other monitor's refusal comes as the end of an open WebSocket, since nothing here waits.
  std::unique_ptr<Socket> open_socket(const Request& request, ConnectionId connection, Response& refusal);
  /// Ends what goes to this address: the monitor has been removed.
  void cut(const std::string& address);

  static constexpr std::chrono::seconds kPatience{8};  // for the head of an answer
  static constexpr std::size_t kMostOfOne = 48;        // connections to one monitor, which takes 64 of a peer
  static constexpr std::size_t kAhead = 64 << 10;      // bytes held for a reader; then the other monitor is not read

 private:
  class Passages;
  class Passage;
  class ResponsePassage;
  class ResponseStream;
  class SocketPassage;
  struct Route;
  bool route(const Request& request, Route& route, Response& refusal) const;

  Server& server_;
  const Gate& gate_;
  const Monitors& monitors_;
  const std::shared_ptr<Passages> passages_;  // some outlive this: their owner is the server
};

}  // namespace sinew::monitor
