#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "hal/linux/memory.hpp"
#include "rt/runner.hpp"

namespace sinew::app {

using Json = nlohmann::ordered_json;

/// What a run has to say at its end: printed line by line for people, or, with --json, one object with the same facts.
/// Thread:  owner.
/// Source:  docs/command-line.md lists the keys.
class RunSummary {
 public:
  struct Form {
    bool json = false;   // the object is printed by finish(), and nothing else
    bool quiet = false;  // no tables
  };
  RunSummary(const rt::Graph& graph, bool virtual_time, Form form);

  /// Threads, modules, chains, losses; in the object also every topic.
  void statistics(rt::Runner& runner);
  void virtual_time(double run_s, double wall_s);
  void hashes(rt::Runner& runner);
  /// What the process has in memory, and for what.
  void memory(const hal::MemoryUse& use);
  /// One line, `label` and `text`, and the keys that say the same.
  void add(std::string_view label, std::string_view text, const Json& keys);
  /// One line for each, and an array under `key` (empty: no reason).
  void add_reasons(std::string_view label, const char* key, const std::vector<std::string>& reasons);
  /// The words that sum it up, and the exit code, which it answers.
  int finish(std::string_view result, int code);

 private:
  const rt::Graph& graph_;
  Form form_;
  Json all_;
};

}  // namespace sinew::app
