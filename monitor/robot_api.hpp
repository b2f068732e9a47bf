#pragma once
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "monitor/control.hpp"
#include "monitor/gate.hpp"
#include "monitor/http/server.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// Robots over HTTP and JSON: /api and below. docs/monitor.md has all paths, replies and errors.
/// Thread:  the server's. Nothing here waits for a robot.
class RobotApi {
 public:
  struct Options {
    std::vector<std::string> panels{};  // paths of panels of one's own, "/panels/battery.js"
    bool runs = false;                  // whether /api/runs is there
  };
  RobotApi(Robots& robots, Gate& gate, Options options) : robots_(robots), gate_(gate), options_(std::move(options)) {}

  static bool has(std::string_view path) { return path == "/api" || path.starts_with("/api/"); }
  void answer(const Request& request, Server::Reply reply);
  /// Why this request may not go to the robot now: somebody else has control. Empty: it may.
  std::string busy_with(const std::string& robot, std::string_view what, std::string_view control_key) const;

  /// A reply to `status` is shown again to all who ask within this time.
  static constexpr std::chrono::milliseconds kStatusAge{200};

 private:
  void about(Server::Reply reply) const;
  void robots(Server::Reply reply);
  void look(const Request& request, const std::string& robot, const std::string& what, Server::Reply reply);
  void change(const Request& request, const std::string& robot, const std::string& what, Server::Reply reply);
  void control(const Request& request, const std::string& robot, Server::Reply reply);

  Robots& robots_;
  Gate& gate_;
  const Options options_;
  std::map<std::string, Control> controls_;  // by robot
};

}  // namespace sinew::monitor
