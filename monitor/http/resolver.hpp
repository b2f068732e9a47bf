#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "monitor/http/worker.hpp"

namespace sinew::monitor {

/// Addresses of hosts by their names. Lookups wait on a thread of their own, for seconds at most.
/// Thread:  the server's.
class Resolver {
 public:
  /// `address` is numeric, of IPv4; empty, with `why`: there is none.
  using Done = std::function<void(const std::string& address, const std::string& why)>;
  /// `post`: calls something in the server's thread, soon.
  explicit Resolver(std::function<void(std::function<void()>)> post) : post_(std::move(post)) {}
  /// Waits for the lookup that is under way, and does none of those that wait.
  ~Resolver() { ends_.store(true, std::memory_order_relaxed); }
  Resolver(const Resolver&) = delete;
  Resolver& operator=(const Resolver&) = delete;

  /// `done` is called later, never at once.
  void resolve(const std::string& host, Done done);

  static constexpr std::chrono::seconds kKnownFor{30};  // an address that was found
  static constexpr std::size_t kMostWaiting = 32;       // names

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    std::string address{};
    Clock::time_point found{};
    std::vector<Done> waiting{};  // empty: nobody looks
  };
  void found(const std::string& host, const std::string& address, const std::string& why);

  const std::function<void(std::function<void()>)> post_;
  std::map<std::string, Entry> entries_;
  std::atomic<bool> ends_{false};
  Worker worker_{kMostWaiting};
};

}  // namespace sinew::monitor
