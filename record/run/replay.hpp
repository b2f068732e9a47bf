#pragma once
#include <optional>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// A message of the record and what came out in its place now.
struct ReplayedMessage {
  std::uint32_t topic = 0;  // of the graph
  rt::Time now;             // of the step
  const rt::SlotHeader &recorded, &again;
};

class ReplayWatcher {
 public:
  virtual ~ReplayWatcher() = default;
  /// References are good until it returns.
  virtual void compared(const ReplayedMessage& message) = 0;
};

struct ReplayOptions {
  std::vector<std::string> modules{};  // none: all
  /// Each module begins behind the last of its saved states before so many seconds of the record, or at its beginning
  /// where there is none. Nothing: at the beginning of the run or, in a file that begins in the middle of it, at the
  /// first state behind which all that the module latched is in the file.
  std::optional<double> from_s{};
  std::optional<double> until_s{};  // of the record: steps that end later are not executed
  /// What the modules publish now is what the others of them latch, under the same sequences; else, and for everything
  /// that comes from elsewhere, it is what was recorded. See ReplayChain for steps that publish less or more.
  bool chain = false;
  std::vector<std::string> keep{};   // "attitude.kp": recorded settings of these parameters are not taken
  ReplayWatcher* watcher = nullptr;  // sees every pair; with it, as with chain, modules go on behind a difference
};

/// Where the steps of a module are not what the record says.
struct ReplayDifference {
  std::string module;
  std::uint32_t step = 0;  // Step::number
  rt::Time now;            // of the step
  std::string what;        // "out.v_world_mps.x", "status", "messages on out", "effect of set_param"
  std::string recorded, again;
};

struct ReplayedModule {
  std::string name;
  std::uint64_t steps = 0, messages = 0;         // executed and compared
  std::optional<rt::Time> from{};                // of the saved state where it began
  std::uint64_t not_compared = 0;                // messages that are not in the file
  std::uint64_t differing = 0;                   // of the compared ones
  std::uint64_t missing = 0, extra = 0;          // messages that only the record has, or only came out now
  std::uint64_t settings_ignored = 0;            // ReplayOptions::keep
  std::optional<ReplayDifference> difference{};  // the first
  std::string stopped{};                         // why its steps end early in the file, or cannot begin
};

struct ReplayReport {
  std::vector<ReplayedModule> modules{};
  std::vector<FileProblem> problems{};  // of the file
  bool midway = false;                  // the file begins in the middle of its run: modules begin at saved states
  rt::Time start;                       // of the record
  rt::Duration length{};                // of the record
  const ReplayDifference* first_difference() const;
  bool complete() const;  // nothing stopped early
};

/// Executes the recorded steps of modules again, in the recorded order, each with what it latched, and compares what
/// comes out, byte for byte.
/// Thread:  owner.
/// Owner:   `graph` is that of the run: same modules in the same order with the parameters of its start, configured on
///          a hal::SilentBoard with the seed of the run; nobody else runs it.
/// Errors:  bad_data with `why` when the file holds no run, or one of other modules.
hal::Result<ReplayReport> replay(Reader& reader, rt::Graph& graph, const ReplayOptions& options, std::string& why);

}  // namespace sinew::record
