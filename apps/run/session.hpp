#pragma once
// One run of a robot, from opening its devices to the exit code, in real and in virtual time. The kinds of boards
// differ in the few functions of RunBoard only.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/flight/mission_watch.hpp"
#include "apps/parent/parent.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/run/run_summary.hpp"

namespace sinew::app {

/// What a session gives to its board.
struct RunContext {
  Prepared& prepared;
  const RunOptions& options;
  hal::Os& system;  // this machine
  hal::Os& os;      // at the robot's pace
  hal::ManualClock clock{};
  std::optional<MissionWatch> mission{};  // from before the first cycle on
  hal::Time begin{};  // of the cycles, by `os` or `clock`; in virtual time RunBoard::start() may set it
  std::uint64_t releases = 0, missed = 0;  // of the graph's threads, after the run; missed: met an unfinished cycle
  std::optional<double> reached_s{}, wall_s{};  // virtual time, after the run
  double lasted_s = 0;                          // real time, after the run: by the robot's clock
  std::string ended_early{};                    // after the run: "interrupted", "stopped"; empty: it was over
  ParentLine* parent = nullptr;                 // null: none watches

  rt::Graph& graph() const { return *prepared.graph; }
  /// The robot's clock: `clock` in virtual time, else `os`.
  const hal::Clock& robot_clock() const { return options.virtual_time ? static_cast<const hal::Clock&>(clock) : os; }
};

/// The board that a run is about: a simulator's, a recorded folder's, real devices.
/// Thread:  owner, but for trouble().
class RunBoard {
 public:
  virtual ~RunBoard() = default;
  /// The name that a robot file has for it: "sim".
  virtual std::string name() const = 0;
  /// Opens it. False, with `why`, when it cannot be had. It may still change the graph.
  virtual bool open(RunContext& run, std::string& why) = 0;
  /// After open().
  virtual hal::Board& devices() = 0;
  /// Why its devices could not be used, in words; empty: what the graph says is enough.
  virtual std::string problem() const { return {}; }
  /// Virtual time: how far the run may go.
  virtual hal::GrantSource& grants() = 0;
  /// Virtual time: what went wrong when a grant failed.
  virtual std::string why_no_grant(const hal::Error& error) const { return error.where; }
  /// Before the first cycle, in real time before a parent watches. False, with `why`, when it does not start.
  virtual bool start(RunContext&, std::string&) { return true; }
  /// The run is over: the mission is, or the board has nothing more.
  virtual bool over(RunContext& run, hal::Time now) = 0;
  /// What is new about it, a line each; now and then during the run, and after its last cycle.
  struct News {
    hal::Time at;  // robot's clock
    std::string text;
  };
  virtual std::vector<News> news(RunContext&, hal::Time) { return {}; }
  /// Real time: it has been silent for long, in words; empty: it has not. Thread: any.
  virtual std::string silence() const { return {}; }
  /// What is wrong with the line to it, for the table and the robot's complaints; empty: nothing. Thread: any.
  virtual std::string trouble() const { return {}; }
  /// After the last cycle: says good-bye, so that the board's last report arrives. Waits at most a second when
  /// hal::stop_requested().
  virtual void end(RunContext&) {}
  /// The plant's last report, JSON, for the recording; empty: none.
  virtual std::string plant_report() { return {}; }
  /// Says how the run went and finishes the summary. Returns the exit code.
  virtual int report(RunContext& run, RunSummary& summary) = 0;
};

/// What the guardian's failsafes did, a line each; adds them to the summary. After the run.
std::vector<std::string> report_failsafes(RunContext& run, RunSummary& summary);

/// Runs it. Returns the exit code of `sinew run`: 0: it went well; 1: it did not, the executor failed, or it was
/// interrupted before it began; 2: it could not begin, and nothing has moved. Ends soon after hal::stop_requested().
/// `parent`: null when none watches. `program`: its start time; nothing when not known.
int run_session(Prepared& prepared, const RunOptions& options, RunBoard& board, ParentLine* parent,
                std::optional<hal::Time> program);

/// Whether a parent process stands beside a run: in real time, where something moves, unless the options say otherwise.
bool needs_parent(const Prepared& prepared, const RunOptions& options);
/// Runs `supervised.body` beside a parent, which stops `supervised.stops` and the real devices of the robot; fills in
/// what the parent knows of the robot. Exit code and errors: run_with_parent().
int run_supervised(Prepared& prepared, const RunOptions& options, Supervised supervised);

}  // namespace sinew::app
