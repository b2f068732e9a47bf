#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/image_stream.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// What the monitor answers: docs/monitor.md lists it. Nothing here waits for a robot.
/// Thread:  the server's.
class Site {
 public:
  Site(Robots& robots, Gate::Options gate) : robots_(robots), gate_(std::move(gate)) {}
  /// Before the server runs; the server must outlive the site.
  void serve_by(Server& server) { server_ = &server; }

  void answer(Request request, ConnectionId connection, Server::Reply reply);

  static constexpr std::chrono::milliseconds kFirstPicture{2000};  // patience for it
  static constexpr std::chrono::seconds kStreamIdle{5};            // then a topic that nobody looks at is let go
  static constexpr std::size_t kMostStreams = 64;

 private:
  using StreamKey = std::pair<std::string, std::string>;  // robot, topic
  struct StreamEntry {
    std::shared_ptr<ImageStream> stream{};
    std::chrono::steady_clock::time_point used{};
  };
  using WithStream = std::function<void(std::shared_ptr<ImageStream> stream, const std::string& why)>;

  void picture(const Request& request, ConnectionId connection, Server::Reply reply);
  void robots(Server::Reply reply) const;
  void ask_robot(const Request& request, Server::Reply reply);
  void with_stream(const std::string& robot, const std::string& topic, WithStream what);
  void sweep();

  Robots& robots_;
  Gate gate_;
  Server* server_ = nullptr;
  Worker undertaker_{SIZE_MAX};  // ends streams, whose threads may have to be waited for
  std::map<StreamKey, StreamEntry> streams_;
  bool sweeping_ = false;
};

/// The headers of every response: no page of another site may show, read or feed ours.
Headers protective_headers();

}  // namespace sinew::monitor
