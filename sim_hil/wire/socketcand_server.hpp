#pragma once
// Simulated CAN buses for clients of socketcand: python-can, our own client, on this machine or another.
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "hal/wide.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "wire/socketcand.hpp"

namespace sinew::sim_hil {

/// Counted since the start.
struct SocketcandServerStats {
  std::uint64_t clients = 0;    // that came
  std::uint64_t refused = 0;    // more than kMostClients at once
  std::uint64_t hung_up = 0;    // by us: nonsense, no bus asked for, or it took nothing for long
  std::uint64_t malformed = 0;  // text that is no element, or frames that cannot be
  std::uint64_t lost = 0;       // frames and answers that a client had no room for
};

/// A socketcand server of one or several buses in memory. The sender of a frame does not get it back; all others on the
/// bus do: other clients, and devices of this process (bus()). Raw mode only. Stamps are this machine's
/// CLOCK_MONOTONIC.
///
/// Strict: an element is at most wire::kSocketcandMax long. The server hangs up on a client after kMostNonsense bad
/// elements, when it is not in raw mode within kGreeting, or when it takes nothing for kStalled. Beyond kMostWaiting
/// bytes in a client's queue, frames and answers are lost and counted. For python-can 4.1, which reads "< ok >" alone
/// and drops the character after an element when it has read half of the next: frames begin kAfterOk after raw mode was
/// granted, and a blank comes before each of them.
/// Thread:  one of its own, which looks every millisecond while there are clients; a port of bus() is for any one
///          thread.
/// RT:      no.
/// Source:  linux-can/socketcand, doc/protocol.md; python-can 4.1.0, interfaces/socketcand/socketcand.py.
class SocketcandServer {
 public:
  static constexpr std::size_t kMostClients = 16, kMostWaiting = 64 * 1024;
  static constexpr std::uint64_t kMostNonsense = 100;
  static constexpr hal::Duration kGreeting = std::chrono::seconds(10), kStalled = std::chrono::seconds(5),
                                 kAfterOk = std::chrono::milliseconds(50);

  /// Errors:  those of starting a thread.
  static hal::Result<std::unique_ptr<SocketcandServer>> open(hal::Os& os, std::unique_ptr<hal::Listener> listener,
                                                             const std::vector<std::string>& buses);
  ~SocketcandServer();

  /// A port of that bus for devices of this process; must not outlive this. Before the first client comes.
  /// Errors:  not_found.
  hal::Result<std::unique_ptr<hal::CanBus>> bus(std::string_view name);
  /// The address of the listener, with the port that the system chose: "tcp:127.0.0.1:29536".
  const std::string& endpoint() const { return listener_->endpoint(); }
  /// Thread: any.
  SocketcandServerStats stats() const noexcept;

 private:
  struct Bus {
    Bus(std::string of, const hal::Clock& clock) : name(std::move(of)), wire(1'000'000, &clock), port(wire.attach()) {}
    std::string name;
    MemoryCan wire;
    MemoryCanPort& port;  // the clients'
  };
  struct Client {
    std::unique_ptr<hal::Stream> stream;
    wire::SocketcandSplitter splitter;
    Bus* bus = nullptr;
    bool raw = false, leaves = false;
    hal::Time since{}, frames_from{}, took{};  // when it came; when its frames begin; when it took something last
    std::uint64_t nonsense = 0, dropped = 0;
    std::string waiting, held;  // to be written; frames that wait for frames_from
  };

  SocketcandServer(hal::Os& os, std::unique_ptr<hal::Listener> listener) : os_(os), listener_(std::move(listener)) {}
  void run();
  void admit(std::unique_ptr<hal::Stream> stream);
  void serve(Client& client, hal::Time now);
  void take(Client& client, std::string_view element, hal::Time now);
  void nonsense(Client& client, std::uint64_t n = 1);
  void hang_up(Client& client);
  void pass_on(Bus& bus, const msg::CanFrame& frame, const Client* from);
  void say(Client& client, std::string_view text);

  hal::Os& os_;
  std::unique_ptr<hal::Listener> listener_;
  std::vector<std::unique_ptr<Bus>> buses_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::atomic<bool> stop_{false};
  hal::Tally came_, refused_, hung_up_, malformed_, lost_;
  std::unique_ptr<hal::Thread> thread_;  // last: ends before what it uses
};

}  // namespace sinew::sim_hil
