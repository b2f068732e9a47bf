#pragma once
// A connection to the robot that comes back after it was lost, and its clock. Inside of the room only.
#include <nlohmann/json.hpp>

#include <memory>
#include <string>

#include "tap/client.hpp"

namespace sinew::net {

using Json = nlohmann::json;

/// Wall time in nanoseconds since 1970 minus the Os's monotonic clock, now.
std::int64_t wall_minus_monotonic();

/// Thread:  owner.
class RobotClient {
 public:
  explicit RobotClient(std::string robot) : robot_(std::move(robot)) {}
  /// Connected, or connects now; tries once a second at most.
  bool reach();
  /// Ends the connection: the next reach() makes a new one.
  void drop();
  tap::Client& operator*() { return *client_; }
  tap::Client* operator->() { return client_.get(); }
  explicit operator bool() const { return client_ != nullptr; }
  /// A request whose reply is `ok`; otherwise null and `why`. A robot that does not answer is dropped.
  Json ask(const char* request, const Json& arguments, std::string& why);
  /// The robot's clock minus the Os's monotonic one: 0, except in virtual time and with --rate.
  std::int64_t clock_offset_ns();

 private:
  std::string robot_;
  std::unique_ptr<tap::Client> client_;
  hal::Time try_again_{};
  bool is_monotonic_ = false;
};

}  // namespace sinew::net
