#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "monitor/http/server.hpp"
#include "monitor/program.hpp"

namespace sinew::monitor {

/// Work on recorded runs that takes its time: one program at a time, whose JSON is kept until others push it out.
/// Thread:  the server's.
class RunJobs {
 public:
  enum class State { none, running, identical, differs, failed, done };
  /// Owner:   the server must outlive it.
  explicit RunJobs(Server& server) : server_(server) {}

  /// `name`: of the job, such as "replay of good". An older result of this name is forgotten. False: another one runs.
  bool begin(const std::string& name, std::vector<std::string> argv);
  /// False: it does not run.
  bool end(const std::string& name);
  /// Ends what runs, and waits for that. Thread: the owner's, when the server does not run any more.
  void stop() { jobs_.clear(); }
  /// The name of the job that runs; empty: none does.
  std::string running() const;
  State state(const std::string& name) const;
  /// {"ok", "state", "seconds", and "result" or "why"}.
  std::string describe(const std::string& name) const;

  static constexpr std::size_t kMostKept = 32;
  static constexpr std::chrono::minutes kPatience{10};

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    std::string name;
    std::uint64_t number;
    Clock::time_point begun;
    State state = State::running;
    double seconds = 0;           // of one that ended
    std::string result{}, why{};  // JSON of the program; or why there is none
    std::unique_ptr<Program> program{};
  };
  const Job* find(const std::string& name) const;
  void ended(std::uint64_t number, State state, std::string result, std::string why);

  Server& server_;
  std::uint64_t last_ = 0;
  std::deque<Job> jobs_;  // the oldest first
};

std::string_view to_string(RunJobs::State state);

}  // namespace sinew::monitor
