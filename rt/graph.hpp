#pragma once
// One robot's threads, modules, topics and bindings, resolved from a GraphSpec, checked as a whole, then configured.
#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/board.hpp"
#include "hal/os.hpp"
#include "rt/graph_spec.hpp"
#include "rt/mailbox.hpp"
#include "rt/module.hpp"
#include "rt/module_types.hpp"
#include "rt/outside_bells.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {

class ExternalSource;
class Guardian;
struct OutsideMessage;

inline constexpr std::uint32_t kNone = 0xFFFFFFFF;  // no such module, topic, thread

struct GraphModule {
  ModuleSpec spec;
  std::unique_ptr<Module> module;  // null: unknown type
  // The same, when it is one:
  DriverModule* driver = nullptr;
  Guardian* guardian = nullptr;
  ExternalSource* external = nullptr;
  Declaration declaration;
  std::uint32_t thread = kNone;
  std::uint32_t position = 0;                       // in its thread
  std::vector<std::uint32_t> topic;                 // per port of the declaration: read or written; kNone: unbound
  std::vector<std::uint32_t> carried_chains;        // per port: bit c: an input through which chain c goes on
  std::vector<std::uint32_t> held;                  // per port: slots that configure() asked for with Setup::hold()
  std::vector<std::optional<ParamRange>> narrowed;  // per parameter: what configure() left of it with Setup::narrow()
};

struct GraphTopic {
  std::string name;
  const msg::TypeInfo* type = nullptr;
  std::uint32_t writer = kNone;  // module
  std::uint32_t port = 0;        // of the writer's declaration
  std::uint32_t image_bytes = 0, image_pixels = 0;
  std::uint32_t history = 0;
  std::uint32_t source_chains = 0, sink_chains = 0;  // bit c: chain c begins or ends here
  std::vector<std::uint32_t> triggers;               // threads
  bool wake_outsiders = false;                       // TopicSpec's
};

struct GraphThread {
  ThreadSpec spec;
  std::vector<std::uint32_t> modules;
  std::uint32_t device_module = kNone;
};

struct GraphChain {
  ChainSpec spec;
  std::uint32_t from = kNone, to = kNone;
};

struct CheckOptions {
  bool virtual_time = false;  // execution-time models are needed; CPU numbers are those of the virtual cores
  std::uint32_t cpus = 0;     // of the machine, in real time; 0: not known
};

struct ConfigureOptions {
  hal::Os* os = nullptr;             // segment in its shared memory; null: ordinary memory
  std::uint32_t first_sequence = 1;  // tests start shortly before the wrap
  std::vector<std::string> taps{};   // topics that the program itself reads, newest message, from one thread
  bool recorded = false;             // a recorder reads every topic, message by message, from one thread
};

/// Identifies a posted change, to ask later when it took effect.
struct Ticket {
  std::uint32_t thread = 0, number = 0;
};

/// Thread:  owner, configure only, except where "any" is said.
class Graph {
 public:
  /// Resolves what it can; check() reports the rest. If there are actuators, the guardian is thread 0 and module 0.
  Graph(GraphSpec spec, const ModuleTypes& types);
  ~Graph();
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  /// All problems in one run; configure() only when there are none.
  std::vector<Problem> check(const CheckOptions& options = {}) const;
  /// Applies the parameters, configures and resets the modules, makes the segment. The last allocation of the run.
  /// Errors:  those of the first failing module; configure_problems() has all of them in words.
  hal::Status configure(hal::Board& board, const ConfigureOptions& options = {});
  /// The first part of configure(): how many slots every topic gets. Allows plan() and slots() without a board; slots
  /// that drivers will hold for their devices are not known then.
  hal::Status make_plan(const ConfigureOptions& options);
  const std::vector<Problem>& configure_problems() const { return configure_problems_; }

  const GraphSpec& spec() const { return spec_; }
  std::vector<GraphModule>& modules() { return modules_; }
  const std::vector<GraphModule>& modules() const { return modules_; }
  const std::vector<GraphTopic>& topics() const { return topics_; }
  const std::vector<GraphThread>& threads() const { return threads_; }
  const std::vector<GraphChain>& chains() const { return chains_; }
  std::uint32_t find_module(std::string_view name) const;  // kNone: no such name
  std::uint32_t find_topic(std::string_view name) const;
  std::uint32_t find_thread(std::string_view name) const;
  /// By name, among those of msg and those that the modules declare; null: not known.
  const msg::TypeInfo* message_type(std::string_view name) const;

  // After configure():
  Segment& segment() { return *segment_; }
  const SegmentPlan& plan() const { return *plan_; }
  /// The memory of the segment, to be handed to other processes; null: ordinary memory.
  const hal::SharedMemory* memory() const { return memory_.get(); }
  /// On which other programs sleep; null: ordinary memory.
  OutsideBells* bells() { return bells_.get(); }
  /// Messages per second of a topic: cycles of its writer, from the periods that release it, or
  /// OutOptions::usual_period where that is longer; 0: a device releases the writer, or not known.
  double planned_rate_hz(std::uint32_t topic) const;
  /// The slots of a topic, term by term.
  SlotSum slots(std::uint32_t topic) const { return plan_->slots(topic_ids_[topic]); }
  TopicId topic_id(std::uint32_t topic) const { return topic_ids_[topic]; }
  WriterId output_writer(std::uint32_t module) const { return output_writers_[module]; }  // kNone: no outputs
  WriterId raw_writer(std::uint32_t module, std::uint32_t port) const { return raw_writers_[module][port]; }
  ConnectionId connection(std::uint32_t module, std::uint32_t port) const { return connections_[module][port]; }
  /// For a Latch of the program, in the order of ConfigureOptions::taps.
  const std::vector<ConnectionId>& taps() const { return taps_; }
  /// For a SlotReader of the recorder, by topic; empty without ConfigureOptions::recorded.
  const std::vector<ConnectionId>& recorder_taps() const { return recorder_taps_; }
  Mailbox& mailbox(std::uint32_t thread) { return *mailboxes_[thread]; }

  // ---- The way in, after configure(). Thread: any. The thread concerned carries out each request at the beginning of
  // its next cycle, before the first step. A request that cannot be done is refused at once; `why` says it in words.
  // Errors: not_found, bad_argument, not_supported; busy when the mailbox (or the room for messages) is full.

  /// In the range that is declared and that the module's device leaves of it (Setup::narrow()).
  hal::Result<Ticket> set_param(std::string_view module, std::string_view name, const ParamValue& value,
                                std::string* why = nullptr);
  /// Steps a module or not; enabling resets it. Not for the guardian and the sources of external topics.
  hal::Result<Ticket> set_enabled(std::string_view module, bool enabled, std::string* why = nullptr);
  /// Of a periodic thread, in the range that the robot file allows. The phase restarts: rt/README.md.
  hal::Result<Ticket> set_period(std::string_view thread, Duration period, std::string* why = nullptr);
  /// Asks the guardian to let commands pass; it may refuse (Effect::refused) and says why in its state.
  hal::Result<Ticket> arm(std::string* why = nullptr);
  hal::Result<Ticket> disarm(std::string* why = nullptr);
  /// One message to an external topic, with finite numbers; an image has a header that fits its bytes and the topic.
  /// The message's own `stamp` becomes OutsideMessage::stamp, or the instant of the step that publishes it when none is
  /// given or the given one is later.
  hal::Result<Ticket> publish(std::string_view topic, const OutsideMessage& message, std::string* why = nullptr);
  /// The bytes of its struct, without a stamp.
  hal::Result<Ticket> publish(std::string_view topic, std::span<const std::byte> message, std::string* why = nullptr);
  /// The result of a request; nothing while it waits, or once a mailbox full of later requests is done.
  std::optional<Effect> effect(Ticket ticket) const;
  /// Requests that met a full mailbox or no room for messages. Thread: any.
  std::uint64_t busy_posts() const { return busy_posts_.value(); }

 private:
  void add_guardian();
  void add_external_sources();
  void add_module(ModuleSpec spec, std::unique_ptr<Module> module);
  void resolve_topics();
  void resolve_threads();
  void resolve_outputs();
  void resolve_inputs();
  void resolve_chains();
  hal::Result<Ticket> ask_guardian(Request::Kind kind, std::string* why);
  hal::Result<Ticket> post(Request request, std::string* why);
  std::string why_not_staged(std::uint32_t topic, const OutsideMessage& message, const hal::Error& error) const;
  hal::Status make_segment(const ConfigureOptions& options);
  void plan_outputs(std::uint32_t module);
  void plan_inputs(std::uint32_t module);
  std::vector<double> thread_rates_hz() const;
  std::uint32_t history_of(std::uint32_t topic) const;

  GraphSpec spec_;
  std::vector<std::string> known_types_;
  std::vector<GraphModule> modules_;
  std::vector<GraphTopic> topics_;
  std::vector<GraphThread> threads_;
  std::vector<GraphChain> chains_;
  std::vector<Problem> configure_problems_;

  std::unique_ptr<SegmentPlan> plan_;
  std::unique_ptr<hal::SharedMemory> memory_;
  std::unique_ptr<Segment> segment_;
  std::unique_ptr<OutsideBells> bells_;
  std::vector<TopicId> topic_ids_;
  std::vector<WriterId> output_writers_;
  std::vector<std::vector<WriterId>> raw_writers_;
  std::vector<std::vector<ConnectionId>> connections_;
  std::vector<ConnectionId> taps_, recorder_taps_;
  std::vector<std::unique_ptr<Mailbox>> mailboxes_;
  hal::Tally busy_posts_;
};

}  // namespace sinew::rt
