#pragma once
// The robot's reply to each request. Include inside of the room only: it shows the JSON library.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "msg/safety.hpp"
#include "rt/exec/runner.hpp"
#include "rt/external_source.hpp"
#include "rt/graph.hpp"
#include "tap/record_control.hpp"
#include "tap/segment_reader.hpp"
#include "tap/topic_notifier.hpp"

namespace sinew::tap {

using Json = nlohmann::ordered_json;

/// A change in a mailbox or asked of the recorder, and the reply that waits for it.
struct Change {
  rt::Ticket ticket;
  Json reply;
  std::optional<std::uint64_t> recorder_request{};  // in place of the ticket
};

struct Reply {
  Json json;  // incomplete while `change` is set
  std::optional<Change> change{};
  const hal::SharedMemory* memory = nullptr;  // goes along with the reply
  bool garbage = false;                       // the text was no request at all
  // One more member of `json` as text, with its name: a long member is not built as JSON first. So there is only one
  // large block, which may be refused. The JSON library allocates also where it frees, and ends the program when it
  // cannot.
  std::string long_member{};
};

/// Thread:  one. It reads what any thread may read (statistics are atomic words; names and descriptions do not change),
///          with one exception: the parameters' values belong to the executors. It copies them at construction, when
///          only mailboxes can change them and all are empty, and then follows change by change.
class Answers {
 public:
  struct Robot {
    std::string name, board;
    bool virtual_time = false;
    std::function<void()> stop;
    std::string robot_file{};
    const hal::Clock* clock = nullptr;                       // its time; null: os
    RecordControl* record_control = nullptr;                 // null: this run has no recorder
    std::function<std::vector<std::string>()> complaints{};  // of devices, one a line; empty: no device can say
  };
  Answers(rt::Graph& graph, rt::Runner& runner, hal::Os& os, TopicNotifier* notifier, Robot robot);

  /// `text` may be any bytes. `client` names the connection, for subscriptions; memory that came with the request is
  /// taken from its `stream`, null: there is none. Throws bad_alloc and nothing else; so do settle() and
  /// still_waiting().
  Reply answer(std::string_view text, std::uint64_t client, hal::Stream* stream = nullptr);
  /// The memory from which this client's messages are copied from now on.
  void set_memory(std::uint64_t client, std::unique_ptr<hal::SharedMemory> memory);
  /// The reply to a change that took effect; nothing while it waits.
  std::optional<Json> settle(const Change& change);
  /// The reply to a change that is not waited for any longer.
  Json still_waiting(const Change& change) const;
  /// Follows changes that took effect meanwhile. Call often. Allocates nothing.
  void follow();
  /// Call when the client is gone.
  void forget(std::uint64_t client);
  /// Added to every status as "outsiders".
  std::function<Json()> outsiders;

 private:
  struct Command;
  static std::span<const Command> commands();
  static const Command* find(std::string_view name);
  /// "; did you mean status?", or nothing.
  static std::string near_requests(std::string_view name);
  Reply run(const Command& command, const Json& request);

  Reply hello(const Json& request);
  Reply topics(const Json& request);
  Reply status(const Json& request);
  Reply params(const Json& request);
  Reply clock(const Json& request);
  Reply memory(const Json& request);
  Reply doorbells(const Json& request);
  Reply subscribe(const Json& request);
  Reply timeline(const Json& request);
  Reply zones(const Json& request);
  Reply set_param(const Json& request);
  Reply enable(const Json& request);
  Reply disable(const Json& request);
  Reply stop(const Json& request);
  Reply set_period(const Json& request);
  Reply arm(const Json& request);
  Reply disarm(const Json& request);
  Reply publish(const Json& request);
  Reply publish_memory(const Json& request);
  Reply publish_bytes(const Json& request);
  Reply post_message(const Json& request, const std::string& topic, const rt::OutsideMessage& message);
  hal::Time now() const { return (robot_.clock ? *robot_.clock : os_).now(); }
  Reply record_start(const Json&) { return ask_recorder(RecordControl::Command::start); }
  Reply record_stop(const Json&) { return ask_recorder(RecordControl::Command::stop); }
  Reply record_status(const Json&) { return ask_recorder(RecordControl::Command::status); }
  Reply record_snapshot(const Json&) { return ask_recorder(RecordControl::Command::snapshot); }
  Reply ask_recorder(RecordControl::Command command);
  std::optional<Json> settle_recorder_request(const Change& change) const;
  Reply set_enabled(const Json& request, bool enabled);
  Reply posted(const hal::Result<rt::Ticket>& ticket, const std::string& why, const Json& members);
  std::optional<msg::SafetyState> safety() const;
  std::vector<std::string> not_ready() const;
  Json guardian_json() const;
  Json param_json(const rt::GraphModule& module, std::size_t param, const rt::ParamValue& value) const;

  struct ParamChange {
    rt::Ticket ticket;
    std::size_t module, param;
    rt::ParamValue value;
  };
  rt::Graph& graph_;
  rt::Runner& runner_;
  hal::Os& os_;
  TopicNotifier* notifier_;  // null: no shared memory
  Robot robot_;
  std::uint64_t client_ = 0;                                              // whose request is being answered
  hal::Stream* stream_ = nullptr;                                         // of that client
  std::map<std::uint64_t, std::unique_ptr<hal::SharedMemory>> memories_;  // of clients that publish bytes
  std::vector<std::vector<rt::ParamValue>> values_;                       // by module and parameter
  std::vector<ParamChange> in_flight_;
  std::optional<SegmentReader> reader_;  // of our own topics, as an outsider
  std::optional<std::uint32_t> safety_topic_;
};

/// The descriptions of topics and types, and all counters, as docs/robot-socket.md has them.
Json directory_json(const rt::Graph& graph);
Json status_json(rt::Graph& graph, rt::Runner& runner);
/// The newest events of all threads, as many as fit into a reply: their description, and the member "events".
struct TimelineText {
  Json description;
  std::string events;
};
TimelineText timeline_text(const rt::Graph& graph, const rt::Runner& runner, hal::Duration last);

/// A refusal, as every failed request is answered.
Json refused(hal::Errc code, const std::string& why);
/// In one line; bytes that are not UTF-8 are replaced.
std::string to_text(const Json& json);
std::string to_text(const Reply& reply);

}  // namespace sinew::tap
