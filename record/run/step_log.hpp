#pragma once
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "rt/exec/runner.hpp"

namespace sinew::record {

/// A recording's entry for one step: rt::StepRecord with the messages that the ports held and gave.
struct LoggedStep {
  struct Input {
    std::uint32_t port = 0;
    bool updated = false;
    std::uint32_t dropped = 0;
    std::vector<std::uint32_t> sequences{};  // held, oldest first
    friend bool operator==(const Input&, const Input&) = default;
  };
  struct Output {
    std::uint32_t port = 0;
    std::uint32_t first = 0, count = 0;     // sequences
    std::vector<std::int64_t> origin_ns{};  // of the first message, by chain
    friend bool operator==(const Output&, const Output&) = default;
  };
  std::uint64_t order = 0;  // in the log of its thread, from 0; a missing number was lost
  std::uint32_t thread = 0, module = 0, number = 0, device_state = 0;
  rt::Time release, now, completed;
  rt::Duration dt{}, exec{};
  rt::StepStatus status = rt::StepStatus::ok;
  bool timed_out = false;
  std::vector<Input> inputs{};    // of every bound input
  std::vector<Output> outputs{};  // of every port that published
  friend bool operator==(const LoggedStep&, const LoggedStep&) = default;
};

/// A request that a thread took from its mailbox; it acts on the steps that follow it in the log of the thread.
struct LoggedRequest {
  std::uint64_t order = 0;
  rt::Request request;
  rt::Effect effect;
  rt::Time now;
};

/// The state of a module after one of its steps: rt/saved_state.hpp.
struct LoggedState {
  std::uint64_t order = 0;
  std::uint32_t thread = 0, module = 0;
  std::uint32_t number = 0;  // of the step before it
  rt::Time completed;        // of that step
  std::span<const std::byte> bytes{};
};

/// The log of the steps: each of the executor's threads writes to its own ring and never waits; entries without room
/// are lost and counted.
/// Thread:  owner for construction; completed() and taken() by the executor's threads; read() by one reader.
/// RT:      completed(), taken(): no allocation, lock or system call.
class StepLog final : public rt::RunObserver {
 public:
  /// `room`: each thread's ring holds the steps of this time, at the rate that the robot file plans; always at least a
  /// few. `state_every`: how often the state of a module is saved, one module after the other; 0: never.
  StepLog(const rt::Graph& graph, rt::Duration room, rt::Duration state_every = {});
  ~StepLog() override;

  void completed(const rt::StepRecord& record) noexcept override;
  void taken(const rt::Request& request, const rt::Effect& effect, rt::Time now) noexcept override;

  class Visitor {
   public:
    virtual ~Visitor() = default;
    /// References are good until it returns.
    virtual void step(const LoggedStep& step) = 0;
    virtual void request(const LoggedRequest& request) = 0;
    virtual void state(const LoggedState& state) = 0;
    /// `entries` of this thread were lost before the next one, or at the end.
    virtual void lost(std::uint32_t thread, std::uint64_t entries) = 0;
  };
  /// Saves the state of the module after its next step, whatever `state_every` says. Thread: the reader.
  void ask_state(std::uint32_t module) noexcept;
  /// Everything in the log of a thread, in its order. `last`: the run is over, so nothing follows the lost entries.
  /// `until`: entries that were over later are left for the next time.
  void read(std::uint32_t thread, Visitor& visitor, bool last = false, rt::Time until = rt::Time{INT64_MAX});
  std::uint32_t threads() const { return static_cast<std::uint32_t>(rings_.size()); }

 private:
  class Ring;
  struct Ports;
  struct State;
  void tell_state(const rt::StepRecord& record) noexcept;
  std::uint32_t* put_inputs(const rt::StepRecord& record, const Ports& ports, std::uint32_t* to) const noexcept;
  std::uint32_t* put_outputs(const rt::StepRecord& record, const Ports& ports, std::uint32_t* to) const noexcept;
  void read_step(std::uint32_t thread, const std::uint32_t* words);

  std::uint32_t chains_;
  std::vector<Ports> ports_;                    // per module
  std::vector<std::unique_ptr<State>> states_;  // per module
  rt::Duration state_every_;
  std::vector<std::unique_ptr<Ring>> rings_;
  std::vector<std::uint64_t> order_;  // per thread: of the next entry; the reader's own
  LoggedStep step_;                   // the reader's own: keeps its memory
};

}  // namespace sinew::record
