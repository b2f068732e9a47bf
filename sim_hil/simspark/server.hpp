#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/door_clients.hpp"
#include "sim_hil/simspark/session.hpp"

namespace sinew::simspark {

struct ServerOptions {
  bool sync = false;       // a cycle begins when every player has said (syn); else each 20 ms
  std::size_t agents = 1;  // sync: so many players have to be there first
  hal::Duration patience = std::chrono::seconds(10);  // sync: who says nothing for longer is let go
};

/// The sockets around the sessions, and the clock. Thread: owner: run() is the loop.
class Server {
 public:
  static constexpr std::size_t kMostClients = 48, kMostMonitors = 8;
  static constexpr hal::Duration kTick = std::chrono::milliseconds(20);
  static constexpr int kMostLateTicks = 5;  // a cycle that is later than this starts the clock anew

  struct Doors {
    std::unique_ptr<hal::Listener> agents, monitors;         // monitors: null for none
    std::function<std::string(const hal::Stream&)> address;  // of a client
    /// Sleeps until one of these handles has something, at most so long; null: sleeps on the clock.
    std::function<void(std::span<const std::intptr_t>, hal::Duration)> wait;
  };
  Server(hal::Os& os, SparkArena& arena, const ServerOptions& options, Doors doors);

  /// Until `stop` says so, a monitor kills the server, or the duration of its time is over; 0: none. Returns how often
  /// the clock had to start anew.
  std::uint64_t run(double duration_s, const std::function<bool()>& stop);
  /// Ends all connections.
  void close() { agents_.clear(), monitors_.clear(); }
  const DoorCounts& counts() const { return counts_; }
  std::uint64_t cycles() const { return cycles_; }

 private:
  void hear_all();
  void tell_all();
  bool all_synced() const;
  void let_go_silent();
  void cycle();
  void sleep(hal::Time until);

  hal::Os& os_;
  SparkArena& arena_;
  ServerOptions options_;
  Doors doors_;
  DoorCounts counts_;
  std::vector<sim_hil::DoorClient<AgentSession>> agents_;
  std::vector<sim_hil::DoorClient<MonitorSession>> monitors_;
  hal::Time last_cycle_{};
  std::uint64_t cycles_ = 0;
};

}  // namespace sinew::simspark
