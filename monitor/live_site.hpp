#pragma once
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "monitor/foxglove/session.hpp"
#include "monitor/http/server.hpp"
#include "monitor/robot_feeds.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// The WebSocket half of the monitor: sessions of the Foxglove protocol on the robots of this machine, as they come and
/// go. Without sessions it does nothing.
/// Thread:  the server's.
/// Owner:   robots, feeds and server must outlive it.
class LiveSite {
 public:
  /// Why a request may not go to a robot now; empty: it may.
  using Refuses = std::function<std::string(const std::string& robot, const std::string& request)>;
  LiveSite(Robots& robots, RobotFeeds& feeds, Server& server);

  /// "/": all robots; "/ROBOT": one that runs. Errors: null, with `refusal`: 404; 400 without one of our subprotocols.
  std::unique_ptr<Socket> open(const Request& request, ConnectionId connection, bool may_command, Refuses refuses,
                               Response& refusal);
  static std::vector<std::string> subprotocols();

  static constexpr std::chrono::milliseconds kPeriod{100};
  static constexpr std::chrono::seconds kFirstRobot{3};  // a session begins without it then

 private:
  using Clock = std::chrono::steady_clock;
  struct Looker {
    foxglove::Session* session;
    std::string robot;  // empty: all
    Clock::time_point since;
    bool begun = false;
  };

  void tick();

  Robots& robots_;
  RobotFeeds& feeds_;
  Server& server_;
  const std::string id_;  // of this start
  using Lookers = std::map<ConnectionId, Looker>;
  const std::shared_ptr<Lookers> lookers_ = std::make_shared<Lookers>();  // sessions may end after us
  bool ticks_ = false;
};

}  // namespace sinew::monitor
