#pragma once
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "monitor/foxglove/session.hpp"
#include "monitor/http/server.hpp"
#include "monitor/http/worker.hpp"
#include "monitor/robot_feed.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// The WebSocket half of the monitor: sessions of the Foxglove protocol on the robots of this machine, as they come and
/// go. Without sessions it does nothing.
/// Thread:  the server's.
/// Owner:   robots and server must outlive it.
class LiveSite {
 public:
  /// Why a request may not go to a robot now; empty: it may.
  using Refuses = std::function<std::string(const std::string& robot, const std::string& request)>;
  LiveSite(Robots& robots, Server& server);

  /// "/": all robots; "/ROBOT": one that runs. Errors: null, with `refusal`: 404; 400 without one of our subprotocols.
  std::unique_ptr<Socket> open(const Request& request, ConnectionId connection, bool may_command, Refuses refuses,
                               Response& refusal);
  static std::vector<std::string> subprotocols();

  static constexpr std::chrono::milliseconds kPeriod{100};
  static constexpr std::chrono::seconds kFeedIdle{5};    // then a robot that nobody looks at is let go
  static constexpr std::chrono::seconds kFirstRobot{3};  // a session begins without it then

 private:
  using Clock = std::chrono::steady_clock;
  struct Feed {
    std::weak_ptr<RobotLink> link{};
    std::shared_ptr<RobotFeed> feed{};
    bool opening = false;
    Clock::time_point used{}, tried{};
  };
  struct Looker {
    foxglove::Session* session;
    std::string robot;  // empty: all
    Clock::time_point since;
    bool begun = false;
  };

  void tick();
  std::shared_ptr<RobotFeed> feed_of(const std::shared_ptr<RobotLink>& link);
  void opened(const std::string& robot, const std::shared_ptr<RobotFeed::Parts>& parts);

  Robots& robots_;
  Server& server_;
  const std::string id_;         // of this start
  Worker undertaker_{SIZE_MAX};  // ends feeds, whose threads have to be waited for
  std::map<std::string, Feed> feeds_;
  std::map<ConnectionId, Looker> lookers_;
  bool ticks_ = false;
};

}  // namespace sinew::monitor
