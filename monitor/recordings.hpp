#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "monitor/http/server.hpp"
#include "monitor/program.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// Recorded files that stand up as robots: each is played by a `sinew bag play` of its own, which ends with us.
/// Thread:  the server's.
class Recordings {
 public:
  struct Options {
    std::string sinew{};  // path of the program
    /// Told when a recording ended that nobody closed: its file, and why. Thread: the server's.
    std::function<void(const std::string& path, const std::string& why)> on_failure{};
  };
  /// Owner:   robots and server must outlive it.
  Recordings(Robots& robots, Server& server, Options options)
      : robots_(robots), server_(server), options_(std::move(options)) {}

  /// Replies {"ok", "robot"} when the file stands as a robot, at once if one does; else 409 (kMost stand already), 502
  /// (`sinew bag play` ended, with its words), 504 (no robot within kPatience).
  void open(const std::string& path, Server::Reply reply);
  /// The same for a file of which nobody waits to hear.
  void open(const std::string& path) {
    open(path, [](const Response&) {});
  }
  /// False: we did not open it. It ends within seconds.
  bool close(const std::string& path);
  bool is_open(const std::string& path) const { return open_.contains(path); }
  /// Ends all, and waits for that. Thread: the owner's, when the server does not run any more.
  void stop();

  static constexpr std::size_t kMost = 8;
  static constexpr std::chrono::seconds kPatience{20};
  static constexpr std::chrono::milliseconds kLook{100};

 private:
  using Clock = std::chrono::steady_clock;
  struct Opened {
    std::uint64_t number;  // a file that is closed and opened again is another one
    std::unique_ptr<Program> program;
    bool closing = false;
  };
  std::string robot_of(const std::string& path) const;
  void start(const std::string& path);
  void ended(const std::string& path, std::uint64_t number, const ProgramEnd& end);
  void wait_for_robot(const std::string& path, const Server::Reply& reply, Clock::time_point until);

  Robots& robots_;
  Server& server_;
  const Options options_;
  std::uint64_t last_ = 0;
  std::map<std::string, Opened> open_;       // by path
  std::map<std::string, std::string> whys_;  // by path: why the last one ended by itself
};

}  // namespace sinew::monitor
