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
  double wait_s = 0;  // time to wait until the robot runs
  bool json = false;
};

/// Thread:  owner.
class LiveRobot {
 public:
  /// Nothing after printing why on standard error: no robot of this name runs (without a name: none or several run), or
  /// it does not answer.
  static std::optional<LiveRobot> find(const LiveOptions& options);
  /// The same without printing, for completion.
  static std::optional<LiveRobot> try_find(const std::string& name);

  /// The reply. Nothing after printing on standard error: the refusal with all its reasons, or the end of the robot.
  std::optional<Json> ask(std::string_view request, const Json& arguments = Json::object());
  /// Reads the topics. Null after printing why not.
  const tap::SegmentReader* reader();
  tap::Client& client() { return *client_; }
  const std::string& name() const { return client_->robot(); }

 private:
  explicit LiveRobot(std::unique_ptr<tap::Client> client) : client_(std::move(client)) {}
  std::unique_ptr<tap::Client> client_;
};

}  // namespace sinew::app
