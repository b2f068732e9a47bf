#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/command/json.hpp"
#include "hal/linux/memory.hpp"
#include "rt/exec/runner.hpp"

namespace sinew::app {

/// The report at the end of a run: printed line by line for people, or, with --json, one object with the same facts.
/// Thread:  owner.
/// Source:  docs/command-line.md lists the keys.
class RunSummary {
 public:
  struct Form {
    bool json = false;    // the object is printed by finish(), and nothing else
    bool quiet = false;   // no tables
    std::string trace{};  // file for the time line; empty: none
  };
  RunSummary(const rt::Graph& graph, bool virtual_time, Form form);

  /// Threads, modules, chains, losses; in the object also every topic.
  /// Writes the time line, too.
  void statistics(rt::Runner& runner);
  /// Chains that missed their budget, in words; after statistics().
  const std::vector<std::string>& failed_chains() const { return failed_chains_; }
  void virtual_time(double run_s, double wall_s);
  /// The grants of a plant in lockstep during that time; each grant is a question and its answer.
  void grants(std::uint32_t count, double run_s, double wall_s);
  /// From the start of the program to the first cycle.
  void start_up(double s);
  void hashes(rt::Runner& runner);
  /// The memory of the process, by purpose.
  void memory(const hal::MemoryUse& use);
  /// One line, `label` and `text`, and the same facts as keys.
  void add(std::string_view label, std::string_view text, const Json& keys);
  /// Only keys, for the object.
  void keep(const Json& keys) { all_.update(keys); }
  /// One line for each, and an array under `key` (empty: no reason).
  void add_reasons(std::string_view label, const char* key, const std::vector<std::string>& reasons);
  /// Whether a chain that missed its budget makes the run fail; by default it does.
  void chains_decide(bool decide) { chains_decide_ = decide; }
  /// Prints the result. Returns the exit code: `code`, but 1 instead of 0 when a chain missed its budget or the time
  /// line could not be written.
  int finish(std::string_view result, int code);

 private:
  const rt::Graph& graph_;
  Form form_;
  Json all_;
  std::vector<std::string> failed_chains_;
  bool trace_failed_ = false, chains_decide_ = true;
};

}  // namespace sinew::app
