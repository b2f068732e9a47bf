#pragma once
// The life of the modules in a cycle, the same under every executor. The executor decides when which thread runs.
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "math/hash.hpp"
#include "rt/commit.hpp"
#include "rt/exec/stats.hpp"
#include "rt/exec/step_code.hpp"
#include "rt/exec/timeline.hpp"
#include "rt/graph.hpp"
#include "rt/latch.hpp"

namespace sinew::rt {

/// What the ports of a module hold for a step, by their index in the declaration, and what the step left behind.
class StepPorts {
 public:
  /// Null: no input, or not bound.
  virtual const InputBase* input(std::uint32_t port) const noexcept = 0;
  /// Messages of this step (outputs) or of the collect() before it (raw topics), oldest first.
  virtual std::span<const SlotHeader* const> published(std::uint32_t port) const noexcept = 0;
  /// The module's state between two steps: rt/saved_state.hpp. `to` has state_bytes(), which never change after
  /// configure(). RT: yes; a copy of so many bytes.
  virtual std::size_t state_bytes() const noexcept = 0;
  virtual void save_state(std::span<std::byte> to) const noexcept = 0;

 protected:
  ~StepPorts() = default;
};

/// One step as it happened, reported when it completes.
struct StepRecord {
  std::uint32_t module = 0, thread = 0;
  std::uint32_t number = 0;  // Step::number
  Time release, now, completed;
  Duration dt{};
  Duration exec{};  // as the executor has it
  StepStatus status = StepStatus::ok;
  bool timed_out = false;
  std::uint32_t device_state = 0;    // DriverModule::device_state() as the step saw it
  const StepPorts* ports = nullptr;  // valid during completed()
};

/// The executor's threads call it; a recorder or a test implements it.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// Thread: executor of the module.
  virtual void completed(const StepRecord& record) noexcept = 0;
  /// A request was taken from the mailbox, at the beginning of a cycle. Thread: executor of its thread.
  virtual void taken(const Request& /*request*/, const Effect& /*effect*/, Time /*now*/) noexcept {}
};

struct RunnerOptions {
  Time start{};                    // of the run, on the executor's clock
  bool hash_topics = false;        // every message of every topic goes into topic_hash()
  std::uint32_t fault_limit = 10;  // faults in a row that stop a module
  RunObserver* observer = nullptr;
  const hal::Clock* clock = nullptr;  // the clock that zones read; null: there are no zones
};

/// What a step needs to know of its cycle.
struct Cycle {
  Time release;
  Duration dt{};
  bool timed_out = false;
};

/// What all modules of a run write to; one writer each (the writer's thread of the topic).
struct RunBoard {
  explicit RunBoard(Graph& graph, const RunnerOptions& options);
  Graph& graph;
  RunnerOptions options;
  std::vector<TopicStats> topics;
  std::vector<math::Hash64> hashes;
  std::unique_ptr<ChainStats[]> chains;
  Timeline timeline;
  std::atomic<bool> zones{false};  // asked for
};

/// One module. The executor calls start() and, when the step's execution time is used up, complete().
/// Thread:  owner for construction, then executor.   RT: yes, after construction.
class ModuleRunner final : StepPorts {
 public:
  ModuleRunner(RunBoard& board, std::uint32_t module);
  ~ModuleRunner();  // DriverModule::end()
  ModuleRunner(const ModuleRunner&) = delete;
  ModuleRunner& operator=(const ModuleRunner&) = delete;

  /// collect(), latch, step(). Answers the raw topics that were filled: they are visible now.
  std::span<const std::uint32_t> start(const Cycle& cycle, Time now) noexcept;
  /// Commits or discards, emit(), releases the inputs. Answers the topics that were published.
  std::span<const std::uint32_t> complete(Time now, Duration exec) noexcept;

  void set_enabled(bool enabled) noexcept;  // between two cycles; enabling resets the module
  void set_param(const Request& request) noexcept;
  std::uint32_t next_step() const { return number_; }
  bool runs() const { return enabled_ && !stopped_; }
  bool stepping() const { return stepping_; }  // between start() and complete() of a step
  const ModuleStats& stats() const { return stats_; }
  std::span<const Count> port_drops() const { return drops_; }  // per port of the declaration

 private:
  void bind();
  const InputBase* input(std::uint32_t port) const noexcept override { return inputs_[port]; }
  std::span<const SlotHeader* const> published(std::uint32_t port) const noexcept override;
  std::size_t state_bytes() const noexcept override;
  void save_state(std::span<std::byte> to) const noexcept override;
  void publish(Commit& commit, std::uint32_t outputs, Time now) noexcept;
  void wake_outsiders(const Commit& commit, std::uint32_t outputs) noexcept;
  void judge() noexcept;

  RunBoard& board_;
  GraphModule& module_;
  const std::uint32_t index_;
  StepCode code_;
  Latch latch_;
  std::unique_ptr<Commit> outputs_;  // null: none
  std::vector<std::unique_ptr<Commit>> raws_;
  std::vector<std::uint32_t> published_;    // graph topics of the last call; room for all
  std::vector<std::uint32_t> topic_of_id_;  // segment's TopicId -> graph topic
  std::vector<InputBase*> inputs_;          // per port; null: no input, or unbound
  struct Source {                           // of what a port publishes
    const Commit* commit = nullptr;         // null: nothing
    std::uint32_t output = 0;
  };
  bool wakes_outsiders_ = false;  // a topic of this module may
  std::vector<Source> sources_;   // per port
  std::vector<Count> drops_;

  StepRecord record_;
  std::optional<RingZones> zones_;
  std::uint32_t number_ = 0, faults_in_row_ = 0;
  bool enabled_ = true, stopped_ = false, stepping_ = false;
  ModuleStats stats_;
};

/// One graph thread: its mailbox, its cycles, its modules.
/// Thread:  owner for construction, then executor.   RT: yes, after construction.
class ThreadRunner {
 public:
  ThreadRunner(RunBoard& board, std::uint32_t thread);
  void set_start(Time start) { last_release_ = start; }  // before the first cycle

  /// First thing in a cycle: empties the mailbox and fixes dt. Answers the period that the mailbox brought, if any: the
  /// executor releases the thread at now + k * period from then on, k = 1, 2, ...
  std::optional<Duration> begin(Time release, bool timed_out, Time now) noexcept;
  /// The cycle's last step has completed.
  void end(Time now) noexcept;
  std::span<const std::uint32_t> start(std::uint32_t position, Time now) noexcept;
  std::span<const std::uint32_t> complete(std::uint32_t position, Time now, Duration exec) noexcept;

  std::size_t size() const { return modules_.size(); }
  ModuleRunner& module(std::uint32_t position) { return *modules_[position]; }
  ThreadStats& stats() { return stats_; }
  TimelineRing& timeline() { return board_.timeline.ring(thread_); }

 private:
  std::optional<Duration> empty_mailbox(Time now) noexcept;
  Effect apply(const Request& request) noexcept;

  RunBoard& board_;
  const std::uint32_t thread_;
  std::vector<std::unique_ptr<ModuleRunner>> modules_;
  Cycle cycle_;
  Time last_release_, begun_;
  std::uint32_t cycles_ = 0;  // begun
  ThreadStats stats_;
};

/// All threads of a configured graph. The graph must outlive it.
/// Thread:  owner for construction; then each ThreadRunner by its executor thread, statistics by any.
class Runner {
 public:
  Runner(Graph& graph, const RunnerOptions& options);
  /// Replaces the options' start for the cycles, where it is known only later. Before the first cycle.
  void set_start(Time start);
  ThreadRunner& thread(std::uint32_t i) { return *threads_[i]; }
  Graph& graph() { return board_.graph; }
  const Graph& graph() const { return board_.graph; }

  const ThreadStats& thread_stats(std::uint32_t thread) { return threads_[thread]->stats(); }
  const ModuleStats& module_stats(std::uint32_t module);
  const TopicStats& topic_stats(std::uint32_t topic) const { return board_.topics[topic]; }
  const ChainStats& chain_stats(std::uint32_t chain) const { return board_.chains[chain]; }
  /// Messages of the topic lost to full queues, all readers together.
  std::uint64_t topic_drops(std::uint32_t topic);
  /// Thread: any, while it runs or after it.
  const Timeline& timeline() const { return board_.timeline; }
  /// From the next steps on. Thread: any.
  void ask_for_zones(bool asked) noexcept { board_.zones.store(asked, std::memory_order_relaxed); }
  /// Over all messages so far, in their order. Call while the run stands still.
  std::uint64_t topic_hash(std::uint32_t topic) const { return board_.hashes[topic].value(); }

 private:
  RunBoard board_;
  std::vector<std::unique_ptr<ThreadRunner>> threads_;
};

}  // namespace sinew::rt
