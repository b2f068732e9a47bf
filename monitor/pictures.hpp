#pragma once
#include <chrono>
#include <memory>
#include <string>

#include "monitor/http/server.hpp"
#include "monitor/robot_feeds.hpp"

namespace sinew::monitor {

/// Pictures over HTTP: /ROBOT/images/TOPIC.KIND.
/// Thread:  the server's.
/// Owner:   feeds and server must outlive it.
class Pictures {
 public:
  Pictures(RobotFeeds& feeds, Server& server) : feeds_(feeds), server_(server) {}
  /// False: the path is none of a picture, and `reply` was not used.
  bool answer(const Request& request, ConnectionId connection, const Server::Reply& reply);

  static constexpr std::chrono::milliseconds kFirst{2000};  // patience for the first picture

 private:
  RobotFeeds& feeds_;
  Server& server_;
};

}  // namespace sinew::monitor
