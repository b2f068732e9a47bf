#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "monitor/http/worker.hpp"
#include "tap/client.hpp"

namespace sinew::monitor {

/// Requests to one running robot, in their order, by a thread of its own: a robot may take two seconds for an answer.
/// Thread:  any; the last owner must not be the link's own thread.
class RobotLink {
 public:
  /// The reply, a JSON object as docs/robot-socket.md has it; "ok" is false with "closed" when the robot is gone.
  using Done = std::function<void(std::string reply)>;
  static constexpr std::size_t kMostWaiting = 64;

  /// `holder`: the process that holds the robot's lock, which may be the parent of the one that answers.
  RobotLink(std::string robot, int holder, std::unique_ptr<tap::Client> client);

  /// `arguments`: a JSON object. `done` is called once, by the link's thread, or at once with "busy" when more than
  /// kMostWaiting wait.
  void ask(std::string request, std::string arguments, Done done);
  /// The same for a request without members that changes nothing: who asks while a reply is on its way or younger than
  /// `age` gets that one.
  void look(const std::string& request, std::chrono::milliseconds age, Done done);
  /// Other work that waits for this robot, by the same thread. False: too much waits already.
  bool post(std::function<void()> what) { return worker_.post(std::move(what)); }

  const std::string& robot() const { return robot_; }
  int holder() const { return holder_; }
  const std::string& hello() const { return hello_; }  // its reply, a JSON object
  bool is_gone() const { return gone_.load(std::memory_order_relaxed); }

 private:
  struct Shared {
    std::string reply{};  // empty: none yet
    std::chrono::steady_clock::time_point at{};
    std::vector<Done> waiting{};  // for the reply that is on its way; empty: none is
  };
  std::string answer(const std::string& request, const std::string& arguments);

  const std::string robot_;
  const int holder_;
  const std::unique_ptr<tap::Client> client_;  // the worker's
  std::string hello_;
  std::atomic<bool> gone_{false};
  std::mutex mutex_;  // of shared_
  std::map<std::string, Shared> shared_;
  Worker worker_{kMostWaiting};
};

}  // namespace sinew::monitor
