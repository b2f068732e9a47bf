#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/result.hpp"
#include "rt/commit.hpp"
#include "rt/exec/runner.hpp"
#include "rt/exec/step_code.hpp"
#include "rt/graph.hpp"

namespace sinew::rt {

/// Executes the recorded steps of one module again, outside of any schedule. A step is a pure function of what the
/// record holds for it, so the same messages come out, byte for byte; the caller compares them. No hook of a driver is
/// called.
///
/// From the beginning: take() for each request and step() for each step, in recorded order. From the middle:
/// restore_state() with the state saved after a step, take() for the parameters as they were by then, then the requests
/// and steps that follow.
/// Thread:  owner.   RT: no, but the module's step is.
/// Owner:   the graph outlives it; it is configured, best on a hal::SilentBoard, with the seed of the run, and nothing
///          else runs its modules. One StepAgain per module; several on one graph are independent.
class StepAgain {
 public:
  /// The messages that one port held. Of a header the step sees stamp, sequence and published; origins go on as they do
  /// in a run.
  struct Input {
    std::span<const SlotHeader* const> messages{};  // oldest first; each header with its message behind it
    bool updated = false;                           // InputBase::updated()
    std::uint32_t dropped = 0;                      // InputBase::dropped()
  };
  StepAgain(Graph& graph, std::uint32_t module);
  StepAgain(const StepAgain&) = delete;
  StepAgain& operator=(const StepAgain&) = delete;
  ~StepAgain();

  /// Uses of the record: number, now, dt, timed_out, device_state, completed. The first step of a module that was
  /// enabled again has number 0: it is reset before.
  /// `inputs`: per port of the declaration; those of outputs are empty.
  /// Errors:  bad_data: no inputs for all ports, more messages than a port holds, messages for a port that is not
  ///          bound; the step was not run.
  hal::Result<StepStatus> step(const StepRecord& recorded, std::span<const Input> inputs);
  /// What the last step published on an output, oldest first; none unless it was ok. Valid until the next step. The
  /// sequences are those of this graph, and go on from its first.
  std::span<const SlotHeader* const> published(std::uint32_t port) const;

  /// A request that the module's thread took before the next step. Answers its effect now, for comparison.
  /// Kind::message: `request.index` is the port of the external source, `message` what was posted, with its pixels.
  /// Errors:  bad_data: there is no such parameter, port or value; bad_argument: the request is not for this module.
  hal::Result<Effect> take(const Request& request, const Effect& recorded, std::span<const std::byte> message = {});

  /// SavedState of the module. The caller checks that the layout is the one of the record.
  std::size_t state_bytes() const;
  std::uint64_t state_layout() const;
  void save_state(std::span<std::byte> to) const;
  /// The next step is the one that follows the saved state in the record.
  hal::Status restore_state(std::span<const std::byte> from);

 private:
  hal::Status hold(std::span<const Input> inputs);
  void let_go();
  void reset();
  CommitInfo commit_info(Time completed) const;

  GraphModule& module_;
  StepCode code_;
  std::unique_ptr<Commit> outputs_;                         // null: none
  std::vector<std::uint32_t> output_of_port_;               // kNone: not an output
  std::vector<std::unique_ptr<const SlotHeader*[]>> held_;  // per port; null: not bound, or an output
  bool fresh_ = true;                                       // reset, and no step since
};

}  // namespace sinew::rt
