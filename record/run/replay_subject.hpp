#pragma once
#include <optional>
#include <vector>

#include "record/run/recorded_run.hpp"
#include "record/run/replay.hpp"
#include "record/run/replay_chain.hpp"
#include "rt/exec/step_again.hpp"

namespace sinew::record {

/// One module under replay: executes its recorded steps with their latched messages and compares the outputs with the
/// record.
/// Thread:  owner.
class ReplaySubject {
 public:
  /// Owner:   all outlive it.
  ReplaySubject(rt::Graph& graph, std::uint32_t module, const RecordedRun& run, ReplayChain& chain,
                const ReplayOptions& options);

  /// Begins after this state; until then it only follows parameters.
  void begin_at(const LoggedState& state, std::uint64_t layout);
  bool begins() const { return begin_.has_value(); }
  bool waits(std::uint64_t order) const { return begin_ && order <= *begin_; }
  /// Its steps end here.
  void stop(std::string why);
  void step(const LoggedStep& s);
  void request(const LoggedRequest& r);

  ReplayedModule report;

 private:
  bool runs() const { return report.stopped.empty() && (goes_on_ || !report.difference); }
  bool begun();
  bool hold(const LoggedStep& s);
  bool hold(const LoggedStep& s, const LoggedStep::Input& in);
  void missing(const LoggedStep& s, std::uint32_t port, const std::string& what);
  bool post(const LoggedStep& s);
  void compare(const LoggedStep& s, std::uint32_t port);
  void compare(const LoggedStep& s, std::uint32_t port, std::uint32_t sequence, const rt::SlotHeader& again);
  void differs(const LoggedStep& s, std::string what, std::string recorded, std::string again);

  const rt::GraphModule& about_;
  rt::StepAgain again_;
  const RecordedRun& run_;
  ReplayChain& chain_;
  ReplayWatcher* const watcher_;
  const bool goes_on_;                  // after a difference
  std::vector<bool> kept_;              // by parameter: recorded settings of it are not taken
  std::optional<std::uint64_t> begin_;  // order of the state to begin with, until it is restored
  std::vector<std::byte> begin_bytes_;
  std::uint64_t begin_layout_ = 0;
  std::vector<rt::StepAgain::Input> inputs_;
  std::vector<std::vector<const rt::SlotHeader*>> held_;
  std::vector<std::optional<std::uint32_t>> last_;  // by port: sequence held last, where it may differ from the record
};

}  // namespace sinew::record
