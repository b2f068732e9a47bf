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

/// The steps of one module once more, outside of any schedule, with what a record says that they had. As each is a pure
/// function of that, the same messages come out, byte for byte; who calls compares them. No hook of a driver is called.
///
/// From the beginning: everything of the module, in its order: take() for requests, step(). From the middle:
/// restore() what was saved after a step, the parameters as they were by then (take()), then what follows that step.
/// Thread:  owner.   RT: no, but the module's step is.
/// Owner:   the graph outlives it; it is configured, best on a hal::SilentBoard, with the seed of the run, and nobody
///          else runs its modules. One StepAgain per module; those of one graph know nothing of each other.
class StepAgain {
 public:
  /// What one port held. Of a message's header the step sees stamp, sequence and published; origins go on as they do in
  /// a run.
  struct Input {
    std::span<const SlotHeader* const> messages{};  // oldest first; each header with its message behind it
    bool updated = false;                           // InputBase::updated()
    std::uint32_t dropped = 0;                      // InputBase::dropped()
  };
  StepAgain(Graph& graph, std::uint32_t module);
  StepAgain(const StepAgain&) = delete;
  StepAgain& operator=(const StepAgain&) = delete;
  ~StepAgain();

  /// Takes of the record: number, now, dt, timed_out, device_state, completed. The first step of a module that was
  /// enabled again has number 0: it is reset before.
  /// `inputs`: per port of the declaration; those of outputs are empty.
  /// Errors:  bad_data: no inputs for all ports, more messages than a port holds, messages for a port that is not
  ///          bound; the step was not run.
  hal::Result<StepStatus> step(const StepRecord& recorded, std::span<const Input> inputs);
  /// What the last step published on an output, oldest first; none unless it was ok. Valid until the next step. The
  /// sequences are those of this graph, and go on from its first.
  std::span<const SlotHeader* const> published(std::uint32_t port) const;

  /// A request that the module's thread took before the next step. Answers what became of it now, for comparison.
  /// Kind::message: `request.index` is the port of the external source, `message` what was posted.
  /// Errors:  bad_data: there is no such parameter, port or value; bad_argument: the request is none for this module.
  hal::Result<Effect> take(const Request& request, const Effect& recorded, std::span<const std::byte> message = {});

  /// SavedState of the module. That its layout is the one of the record is for who calls to see to.
  std::size_t state_bytes() const;
  std::uint64_t state_layout() const;
  void save_state(std::span<std::byte> to) const;
  /// The next step is the one after which, in the record, the state was saved.
  hal::Status restore_state(std::span<const std::byte> from);

 private:
  hal::Status hold(std::span<const Input> inputs);
  void let_go();
  void reset();
  CommitInfo commit_info(Time completed) const;

  GraphModule& module_;
  StepCode code_;
  std::unique_ptr<Commit> outputs_;                         // null: none
  std::vector<std::uint32_t> output_of_port_;               // kNone: it is none
  std::vector<std::unique_ptr<const SlotHeader*[]>> held_;  // per port; null: not bound, or an output
  bool fresh_ = true;                                       // reset, and no step since
};

}  // namespace sinew::rt
