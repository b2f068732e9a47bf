#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/http/worker.hpp"
#include "monitor/recordings.hpp"
#include "monitor/run_jobs.hpp"

namespace sinew::monitor {

/// Recorded runs in one folder, FOLDER/NAME/run.mcap, over HTTP: /api/runs and below, as docs/monitor.md lists it. All
/// that looks into a file is a process of its own: a damaged file harms nobody.
/// A file that is downloaded is read by the server's thread: a disk that stalls holds up the monitor, no robot.
/// Thread:  the server's.
class Runs {
 public:
  struct Options {
    std::string folder{};  // empty: no runs are shown
    /// Recorded runs that stand up as robots from the beginning; and who is told when one cannot.
    std::vector<std::string> files{};
    std::function<void(const std::string& path, const std::string& why)> on_failure{};
  };
  /// `sinew`: path of the program. Owner: robots, server and gate must outlive it.
  Runs(Robots& robots, Server& server, Gate& gate, std::string sinew, Options options);
  ~Runs() { stop(); }
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  bool are_shown() const { return !options_.folder.empty(); }
  /// False: the path is none of runs, and `reply` was not used.
  bool answer(const Request& request, const Server::Reply& reply);
  /// Ends all programs that were started, and waits for that. Thread: the owner's, when the server does not run any
  /// more.
  void stop();

  static constexpr std::size_t kMostShown = 200;  // the newest

 private:
  struct Known {
    std::int64_t written_ns = 0;
    std::uint64_t bytes = 0;
    std::string robot{}, verdict{};
    std::int64_t begin_unix_ns = 0;
    double duration_s = 0;
  };
  struct Listed {
    std::string name, path;
    Known known;
  };
  std::vector<Listed> look();  // the worker's thread; so is known_
  Known describe(const std::string& path, Known known) const;
  std::string list(const std::vector<Listed>& runs) const;
  void look_at(const Request& request, const std::string& name, std::string_view what,
               const Server::Reply& reply) const;
  void change(const Request& request, const std::string& name, std::string_view what, const Server::Reply& reply);
  void begin(const std::string& job, std::vector<std::string> argv, const Server::Reply& reply);
  void send_file(const std::string& name, const Server::Reply& reply) const;
  std::string path_of(const std::string& name) const;

  Server& server_;
  Gate& gate_;
  const std::string sinew_;
  const Options options_;
  Recordings recordings_;
  RunJobs jobs_;
  std::atomic<bool> stop_{false};
  std::map<std::string, Known> known_;  // by name
  std::optional<Worker> worker_{16};    // nothing: stopped
};

}  // namespace sinew::monitor
