#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "monitor/doctor.hpp"
#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/live_site.hpp"
#include "monitor/monitors.hpp"
#include "monitor/page.hpp"
#include "monitor/pictures.hpp"
#include "monitor/relay.hpp"
#include "monitor/robot_api.hpp"
#include "monitor/robots.hpp"
#include "monitor/runs.hpp"

namespace sinew::monitor {

/// What the monitor answers: docs/monitor.md lists it. Nothing here waits for a robot.
/// Thread:  the server's.
/// Owner:   robots and server must outlive it. Destroy it when the server does not run any more: run() has ended the
///          connections that know it.
class Site {
 public:
  struct Options {
    Gate::Options gate{};
    RobotApi::Options api{};
    std::string panels{};  // a folder of panels of one's own; empty: none
    Runs::Options runs{};
    std::string sinew{};  // path of the program: what looks into recorded runs and at this machine
  };
  Site(Robots& robots, Server& server, Options options);

  /// A monitor of another machine, as Monitors::add.
  bool add_monitor(const std::string& address, std::string& why) { return monitors_.add(address, why); }

  void answer(Request request, ConnectionId connection, const Server::Reply& reply);
  /// As Server::OnSocket.
  std::unique_ptr<Socket> open_socket(const Request& request, ConnectionId connection, Response& refusal);
  RobotFeeds& feeds() { return feeds_; }

 private:
  Gate gate_;
  Page page_;
  Runs runs_;
  Doctor doctor_;
  RobotApi api_;
  RobotFeeds feeds_;
  Pictures pictures_;
  LiveSite live_;
  Monitors monitors_;
  Relay relay_;
};

/// The headers of every response: no page of another site may show, read or feed ours.
Headers protective_headers();

}  // namespace sinew::monitor
