#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/command/json.hpp"
#include "apps/flight/story.hpp"
#include "apps/robot_file/world_report.hpp"
#include "hal/linux/memory.hpp"
#include "rt/exec/runner.hpp"

namespace sinew::app {

/// Whether a run counts as a measurement of timing. It says nothing about the mission.
struct TimingVerdict {
  std::vector<std::string> reasons{};  // why it does not count; empty: it does
  std::string worst{}, what_to_do{};   // of those, in one line each
};

/// The end of a run: the mission's result, the timing's, a time line of what happened, and all tables. Nothing is
/// printed before finish(): for people at most kMostLines lines, or with --verbose all; with --json one object with the
/// same facts. Thread:  owner. Source:  docs/command-line.md shows the lines and lists the keys.
class RunSummary {
 public:
  struct Form {
    bool json = false;     // only the object
    bool quiet = false;    // only the mission's line
    bool verbose = false;  // the whole time line, and all that add() and its like were given
    bool strict = false;   // a run that does not count as a measurement has failed
    std::string trace{};   // file for the time line of the threads; empty: none
  };
  RunSummary(const rt::Graph& graph, bool virtual_time, Form form);

  /// Threads, modules, chains, losses; in the object also every topic.
  /// Writes the time line of the threads, too.
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
  /// For --verbose one line, `label` and `text`, and the same facts as keys.
  void add(std::string_view label, std::string_view text, const Json& keys);
  /// Only keys, for the object.
  void keep(const Json& keys) { all_.update(keys); }
  /// For --verbose one line for each, and an array under `key` (empty: no reason).
  void add_reasons(std::string_view label, const char* key, const std::vector<std::string>& reasons);
  /// Whether chains that missed their budget count; by default they do: against the timing, in virtual time against the
  /// mission.
  void chains_decide(bool decide) { chains_decide_ = decide; }

  Story& story() { return story_; }
  /// A figure of the mission, for its line: "landing error 0.043 m (at most 0.15)"; in the object with its limit.
  void measure(WorldReport::Measure measure) { measures_.push_back(std::move(measure)); }
  /// The command that repeats the run, which stands beside a bad outcome.
  void again(std::string command) { again_ = std::move(command); }
  /// One line on why the outcome is not good.
  void why(std::string text) { why_ = std::move(text); }
  /// Of a board that judges it; of others only the chains do.
  void timing(TimingVerdict verdict) { timing_ = std::move(verdict), judged_ = true; }
  /// The run was ended before its own end: `how` ("interrupted"), and when by the robot's clock.
  void ended_early(std::string_view how, double at_s);
  /// The world behind the run was lost: `what` ("the simulator died (signal 9)"), when by the robot's clock, and more
  /// about why. Such a run counts neither as a mission nor as a measurement.
  void lost(std::string_view what, double at_s, std::string_view why);
  /// How the run went, for its recording.
  struct Result {
    std::string end;           // kOver, "interrupted", "stopped", or how the world was lost
    std::string outcome, why;  // of the mission
    int code = 0;              // of the program
    std::string timing;        // the worst reason why it is no measurement; empty: it is, or nothing judges it
  };
  /// finish() calls it when all is known, before anything is printed; it may still add().
  void before_print(std::function<void(const Result&)> what) { before_print_ = std::move(what); }
  /// Where the run was recorded, and what that is good for.
  void recorded(const std::string& path, std::string_view text);

  /// Prints it all. `outcome`: of the mission, in words; `code`: 0 when it is good. Returns the exit code: `code`, but
  /// 1 instead of 0 when in virtual time a chain missed its budget, when the timing does not count and decides
  /// (--strict, and in virtual time, where no machine disturbs), or when the time line of the threads could not be
  /// written.
  int finish(std::string_view outcome, int code);

  static constexpr std::size_t kMostLines = 15, kMostEvents = 10;
  static constexpr const char* kOver = "over";  // the end of a run that nothing ended early

 private:
  void judge_chains(std::string& outcome, int& code);
  void judge_end(std::string& outcome, int& code);
  std::string timing_line() const;
  void print(const std::string& mission, int code) const;

  const rt::Graph& graph_;
  Form form_;
  const bool virtual_;
  Json all_;
  std::string details_;  // as --verbose prints them
  Story story_;
  std::vector<WorldReport::Measure> measures_;
  std::vector<std::string> failed_chains_;
  std::string why_, again_, recorded_, recording_, virtual_time_;
  TimingVerdict timing_;
  std::string end_ = kOver, ended_early_;  // how; and with its time, where something ended it early
  std::string lost_, lost_why_;
  double lost_at_s_ = 0;
  std::function<void(const Result&)> before_print_;
  bool trace_failed_ = false, chains_decide_ = true, judged_ = false;
};

}  // namespace sinew::app
