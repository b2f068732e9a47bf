#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "monitor/http/server.hpp"
#include "monitor/http/worker.hpp"

namespace sinew::monitor {

/// Recorded runs in one folder, FOLDER/NAME/run.mcap, over HTTP: /api/runs lists them, /api/runs/NAME/run.mcap is the
/// file. What is in a file says `sinew bag info` in a process of its own: a damaged file harms nobody.
/// A file is read by the server's thread: a disk that stalls holds up the monitor, no robot.
/// Thread:  the server's.
class Runs {
 public:
  struct Options {
    std::string folder{};  // empty: no runs are shown
    std::string sinew{};   // path of the program
  };
  explicit Runs(Options options) : options_(std::move(options)) {}

  bool are_shown() const { return !options_.folder.empty(); }
  /// False: the path is none of runs, and `reply` was not used.
  bool answer(const Request& request, const Server::Reply& reply);

  static constexpr std::size_t kMostShown = 200;  // the newest

 private:
  struct Known {
    std::int64_t written_ns = 0;
    std::uint64_t bytes = 0;
    std::string line{};  // a JSON object
  };
  std::string list();  // the worker's thread; so is known_
  std::string describe(const std::string& name, const std::string& path, std::uint64_t bytes) const;
  void send_file(const std::string& name, const Server::Reply& reply) const;

  const Options options_;
  std::map<std::string, Known> known_;  // by name
  Worker worker_{16};
};

}  // namespace sinew::monitor
