#pragma once
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "rt/exec/runner.hpp"

namespace sinew::app {

/// Threads and topics at one instant, from a run of our own or from the socket of another one.
struct StatusRows {
  struct Thread {
    std::string name;
    int priority = 0;
    std::uint64_t cycles = 0, overruns = 0;
    rt::Duration late_p50{}, late_p99{}, exec_p99{};
  };
  struct Topic {
    std::string name;
    std::uint64_t messages = 0, lost = 0;
    rt::Duration age_p99{};
  };
  std::vector<Thread> threads;
  std::vector<Topic> topics;
  std::string gaps;  // gap_lines() of a run of our own
};

StatusRows rows_of(const rt::Graph& graph, rt::Runner& runner);

/// Rows as text, with rates over the last second: since the newest call that is at least so old, or since the first.
/// Thread:  owner.
class StatusTable {
 public:
  /// `now`: by the robot's clock when the rows were read.
  /// Shape:   one line a thread and one a topic, at most `columns` wide; 0: as wide as they are.
  std::string render(const StatusRows& rows, rt::Time now, int columns);

 private:
  struct Count {
    rt::Time at;
    std::uint64_t count = 0;
  };
  std::string rate(const std::string& key, std::uint64_t count, rt::Time now);
  std::map<std::string, std::deque<Count>> counts_;  // oldest first
};

}  // namespace sinew::app
