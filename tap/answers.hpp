#pragma once
// A running robot's reply to each request. Include inside of the room only: it shows the JSON library.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "msg/team.hpp"
#include "rt/exec/runner.hpp"
#include "rt/external_source.hpp"
#include "rt/graph.hpp"
#include "tap/answering.hpp"
#include "tap/newest_message.hpp"
#include "tap/record_control.hpp"
#include "tap/safety_reader.hpp"

namespace sinew::tap {

/// Thread:  one. It reads what any thread may read (statistics are atomic words; names and descriptions do not change),
///          with one exception: the parameters' values belong to the executors. It copies them at construction, when
///          only mailboxes can change them and all are empty, and then follows change by change.
class Answers final : public Answering {
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
  Answers(rt::Graph& graph, rt::Runner& runner, hal::Os& os, Robot robot);

  std::optional<Json> settle(const Change& change) override;
  Json still_waiting(const Change& change) const override;
  void follow() override;
  void forget(std::uint64_t client) override;
  /// The memory from which this client's messages are copied from now on.
  void set_memory(std::uint64_t client, std::unique_ptr<hal::SharedMemory> memory);

 private:
  struct Command;
  static std::span<const Command> commands();
  std::optional<Reply> reply_to(std::string_view name, const Json& request) override;
  std::vector<std::string> requests() const override;
  std::optional<Bell> bell_of(const std::string& topic, std::string& why) const override;

  Json counters();
  Reply hello(const Json& request);
  Reply topics(const Json& request);
  Reply status(const Json& request);
  Reply params(const Json& request);
  Reply clock(const Json& request);
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
  Reply publish_several(const Json& messages);
  Reply publish_one(const Json& request);
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

  struct ParamChange {
    rt::Ticket ticket;
    std::size_t module, param;
    rt::ParamValue value;
  };
  rt::Graph& graph_;
  rt::Runner& runner_;
  hal::Os& os_;
  Robot robot_;
  std::map<std::uint64_t, std::unique_ptr<hal::SharedMemory>> memories_;  // of clients that publish bytes
  std::vector<std::vector<rt::ParamValue>> values_;                       // by module and parameter
  std::vector<ParamChange> in_flight_;
  SafetyReader safety_;
  NewestMessage<msg::TeamState> team_;
};

}  // namespace sinew::tap
