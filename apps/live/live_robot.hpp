#pragma once
// A running robot, for the commands that look at it and steer it.
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "apps/command/json.hpp"
#include "tap/client.hpp"

namespace sinew::app {

/// The options of every such command.
struct LiveOptions {
  std::string robot;  // name; empty: the only one that runs
  double wait_s = 0;  // for it to run
  bool json = false;
};

/// Thread:  owner.
class LiveRobot {
 public:
  /// Nothing, after why was said on standard error: none of this name runs (or none, or several) or it does not answer.
  static std::optional<LiveRobot> find(const LiveOptions& options);
  /// The same without words: for completion.
  static std::optional<LiveRobot> try_find(const std::string& name);

  /// The reply. Nothing, after the refusal (with all its reasons) or the end of the robot was said on standard error.
  std::optional<Json> ask(std::string_view request, const Json& arguments = Json::object());
  /// Of the topics. Null after it was said why there is none.
  const tap::SegmentReader* reader();
  tap::Client& client() { return *client_; }
  const std::string& name() const { return client_->robot(); }

 private:
  explicit LiveRobot(std::unique_ptr<tap::Client> client) : client_(std::move(client)) {}
  std::unique_ptr<tap::Client> client_;
};

}  // namespace sinew::app
