#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/live_site.hpp"
#include "monitor/page.hpp"
#include "monitor/pictures.hpp"
#include "monitor/robot_api.hpp"
#include "monitor/robots.hpp"
#include "monitor/runs.hpp"

namespace sinew::monitor {

/// What the monitor answers: docs/monitor.md lists it. Nothing here waits for a robot.
/// Thread:  the server's.
/// Owner:   robots and server must outlive it.
class Site {
 public:
  struct Options {
    Gate::Options gate{};
    RobotApi::Options api{};
    std::string panels{};  // a folder of panels of one's own; empty: none
    Runs::Options runs{};
  };
  Site(Robots& robots, Server& server, Options options);

  void answer(Request request, ConnectionId connection, const Server::Reply& reply);
  /// As Server::OnSocket.
  std::unique_ptr<Socket> open_socket(const Request& request, ConnectionId connection, Response& refusal);
  RobotFeeds& feeds() { return feeds_; }

 private:
  Gate gate_;
  Page page_;
  Runs runs_;
  RobotApi api_;
  RobotFeeds feeds_;
  Pictures pictures_;
  LiveSite live_;
};

/// The headers of every response: no page of another site may show, read or feed ours.
Headers protective_headers();

}  // namespace sinew::monitor
