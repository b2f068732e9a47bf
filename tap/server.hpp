#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "rt/exec/runner.hpp"
#include "rt/exec/stats.hpp"
#include "tap/names.hpp"
#include "tap/record_control.hpp"

namespace sinew::tap {

class Answering;  // tap/answering.hpp

/// The most that clients may take.
struct ServerLimits {
  std::uint32_t max_clients = 16;                                  // 62 at most
  std::uint32_t max_per_process = 4;                               // connections of one process
  hal::Duration may_be_replaced_after = std::chrono::seconds(10);  // without a request, when all places are taken
  std::uint32_t requests_per_s = 200;                              // of one client; more wait in its socket
  std::size_t long_reply_bytes = 8 * 1024 * 1024;                  // for all clients' replies above 128 KiB together
  hal::Duration patience =
      std::chrono::seconds(2);  // for a whole request, for a whole reply to be taken, and for a change
};

/// What a running robot says besides its graph.
struct ServerOptions {
  std::string board{};                                     // for `hello`
  bool virtual_time = false;                               // for `hello`
  std::function<void()> stop{};                            // what `stop` does; empty: refused
  std::string robot_file{};                                // absolute path, for `hello`; empty: none
  const hal::Clock* clock = nullptr;                       // the robot's, read by any thread; null: os
  RecordControl* record_control = nullptr;                 // for `record.*`; null: refused
  std::function<std::vector<std::string>()> complaints{};  // of devices, for `status`; called by any thread
  ServerLimits limits{};
};

/// Counts of what outsiders did. The loops see nothing of them.
struct ServerStats {
  rt::Count accepted, requests, refused_peers, refused_full, made_room, garbage, closed_for_garbage, closed_slow,
      throttled, refused_replies, out_of_memory;
};

/// The robot's socket: answers requests of other programs, hands them the memory of the topics, rings the doorbells.
/// Owns two threads of ordinary priority.
/// Thread:  owner; stats(): any.
class Server {
 public:
  /// Of a running robot. Changes of the robot go through the graph's mailboxes; everything else is read from words that
  /// any thread may read.
  /// Owner:   graph, runner, os and clock must outlive it; made after graph.configure(), before anything else changes
  ///          parameters.
  /// Errors:  busy, denied, io of the socket or the threads.
  static hal::Result<std::unique_ptr<Server>> open(const Name& name, rt::Graph& graph, rt::Runner& runner, hal::Os& os,
                                                   const ServerOptions& options = {});
  /// Of anything else that answers.
  /// Owner:   os must outlive it.
  /// Errors:  as above.
  static hal::Result<std::unique_ptr<Server>> open(const Name& name, std::unique_ptr<Answering> answering, hal::Os& os,
                                                   const ServerLimits& limits = {});
  ~Server();  // ends both threads and all connections
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const ServerStats& stats() const;

 private:
  class Body;
  explicit Server(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace sinew::tap
