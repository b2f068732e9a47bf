#pragma once
// A recorded robot's reply to each request. Only for code that answers requests: it shows the JSON library.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/bag/recorded_about.hpp"
#include "record/run/playback.hpp"
#include "record/run/step_counts.hpp"
#include "tap/answering.hpp"
#include "tap/safety_reader.hpp"

namespace sinew::app {

/// A file that stands up as a robot: docs/robot-socket.md, "A recorded run".
/// Thread:  the server's, but for construction.
/// Owner:   playback and counts outlive it.
class RecordedAnswers final : public tap::Answering {
 public:
  struct Recording {
    std::string name;  // of the robot on this machine
    std::string path;  // absolute
    std::vector<record::RecordedTopics::Unknown> not_shown{};
  };
  RecordedAnswers(record::Playback& playback, const record::StepCounts& counts, RecordedAbout about,
                  Recording recording);

  std::optional<tap::Json> settle(const tap::Change& change) override;
  tap::Json still_waiting(const tap::Change& change) const override;

 private:
  using Json = tap::Json;
  using Reply = tap::Reply;
  struct Command;
  static const std::vector<Command>& commands();
  std::optional<Reply> reply_to(std::string_view name, const Json& request) override;
  std::vector<std::string> requests() const override;
  std::optional<Bell> bell_of(const std::string& topic, std::string& why) const override;

  Reply hello(const Json& request);
  Reply topics(const Json& request);
  Reply status(const Json& request);
  Reply clock(const Json& request);
  Reply params(const Json& request);
  Reply timeline(const Json& request);
  Reply playback(const Json& request);
  Reply play(const Json& request);
  Reply pause(const Json& request);
  Reply seek(const Json& request);
  Reply step(const Json& request);
  Reply speed(const Json& request);
  Reply refuse_change(const Json& request);

  static Reply waits_for(std::uint64_t number);
  Json playback_json() const;
  Json threads_json() const;
  bool wakes_outsiders(const std::string& topic) const;
  std::vector<std::string> readers_of(const std::string& topic) const;
  Json modules_json() const;
  std::string no_such_topic(const std::string& name) const;
  std::optional<std::size_t> find_topic(const std::string& name) const;
  const rt::GraphModule* module_of(const std::string& name) const;
  std::string thread_of(const std::string& module) const;

  record::Playback& playback_;
  const record::StepCounts& counts_;
  const RecordedAbout about_;
  const Recording recording_;
  const rt::GraphSpec spec_;  // of the recorded robot; empty: the file does not have it
  tap::SafetyReader safety_;
};

}  // namespace sinew::app
