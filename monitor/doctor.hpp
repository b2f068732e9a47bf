#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "monitor/http/server.hpp"
#include "monitor/program.hpp"

namespace sinew::monitor {

/// What `sinew doctor` says of this machine, over HTTP: /api/doctor. It runs at most once at a time, and only while
/// somebody asks.
/// Thread:  the server's.
class Doctor {
 public:
  static constexpr std::string_view kPath = "/api/doctor";
  /// `sinew`: path of the program. Owner: the server must outlive it.
  Doctor(Server& server, std::string sinew) : server_(server), sinew_(std::move(sinew)) {}

  /// The JSON of `sinew doctor`, of at most kAge; 502 when it has none, 409 when too many wait.
  void answer(Server::Reply reply);

  static constexpr std::chrono::seconds kAge{5};
  static constexpr std::size_t kMostWaiting = 64;

 private:
  using Clock = std::chrono::steady_clock;
  void ended(const ProgramEnd& end);

  Server& server_;
  const std::string sinew_;
  std::string reply_{};  // empty: none yet
  Clock::time_point at_{};
  std::vector<Server::Reply> waiting_{};  // for the program that runs
  std::unique_ptr<Program> program_{};
};

}  // namespace sinew::monitor
