#pragma once
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"

namespace sinew::monitor {

/// Where a monitor of another machine is.
struct MonitorPlace {
  std::string address{};  // "HOST:PORT" in lower case: its name here
  std::string host{};
  std::uint16_t port = 0;
  bool tls = false;
};

/// Monitors on other machines that this one knows, and whether they answer: /api/monitors. They are looked at only
/// while somebody asks.
/// Thread:  the server's.
/// Owner:   server and gate must outlive it.
class Monitors {
 public:
  using OnRemoved = std::function<void(const std::string& address)>;
  Monitors(Server& server, Gate& gate, OnRemoved on_removed);
  ~Monitors();

  static bool has(std::string_view path) { return path == "/api/monitors" || path.starts_with("/api/monitors/"); }
  /// A request below /api/monitors: docs/monitor.md has all of them.
  void answer(const Request& request, const Server::Reply& reply);

  /// "HOST:PORT", or a URL of it: "https://HOST:PORT" for TLS. One that is known already stays, with the TLS of now.
  /// Errors: false, with `why`: no address of this form; kMost are known.
  bool add(std::string_view address, std::string& why);
  /// Null: none is known by this address.
  const MonitorPlace* find(std::string_view address) const;

  static constexpr std::size_t kMost = 16;
  static constexpr std::chrono::milliseconds kLook{1000};  // at most so often
  static constexpr std::chrono::seconds kPatience{5};      // for the answer to a look
  static constexpr std::size_t kMostAnswer = 64 << 10;     // bytes of it

 private:
  class Look;
  using Clock = std::chrono::steady_clock;
  enum class State { reached, not_reached, refused };
  struct Known {
    MonitorPlace place{};
    State state = State::not_reached;
    std::string why{"not asked yet"}, program{};
    bool commands = false;
    Clock::time_point asked{};
    std::unique_ptr<Look> look{};
  };
  void list(const Server::Reply& reply);
  void remove(const std::string& address);
  void look(Known& known);

  Server& server_;
  Gate& gate_;
  const OnRemoved on_removed_;
  std::map<std::string, Known, std::less<>> known_;  // by address
};

/// Errors: false, with `why`.
bool parse_place(std::string_view text, MonitorPlace& place, std::string& why);

}  // namespace sinew::monitor
