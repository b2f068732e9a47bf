#include "monitor/live_site.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::monitor {
namespace {

std::string new_id() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

}  // namespace

LiveSite::LiveSite(Robots& robots, RobotFeeds& feeds, Server& server)
    : robots_(robots), feeds_(feeds), server_(server), id_(new_id()) {}

std::vector<std::string> LiveSite::subprotocols() {
  return {std::string(foxglove::kSubprotocol), std::string(foxglove::kSdkSubprotocol)};
}

std::unique_ptr<Socket> LiveSite::open(const Request& request, ConnectionId connection, bool may_command,
                                       Refuses refuses, Response& refusal) {
  foxglove::Session::Options options;
  options.sdk = request.subprotocol == foxglove::kSdkSubprotocol;
  if (!options.sdk && request.subprotocol != foxglove::kSubprotocol) {
    refusal =
        plain(400, fmt::format("this WebSocket speaks {} and {}", foxglove::kSubprotocol, foxglove::kSdkSubprotocol));
    return nullptr;
  }
  const std::string robot = request.path.substr(1);
  if (!robot.empty() && !robots_.find(robot)) {
    refusal = plain(404, fmt::format("no robot '{}' runs; ws://HOST/ has all", robot));
    return nullptr;
  }
  options.may_command = may_command, options.all_robots = robot.empty();
  options.name = "sinew monitor", options.id = id_;
  foxglove::Session::Host host;
  Server* const server = &server_;
  host.wake = [server, connection] { server->wake(connection); };
  host.wake_in = [server, connection](std::chrono::milliseconds time) {
    server->after(time, [server, connection] { server->wake(connection); });
  };
  host.post = [server](std::function<void()> what) { server->post(std::move(what)); };
  host.link = [server, connection] { return server->link(connection); };
  host.now = [] { return Clock::now(); };
  host.refuses = std::move(refuses);
  host.closed = [weak = std::weak_ptr(lookers_), connection] {
    if (const auto lookers = weak.lock()) lookers->erase(connection);
  };
  auto session = std::make_unique<foxglove::Session>(std::move(options), std::move(host));
  (*lookers_)[connection] = {session.get(), robot, Clock::now()};
  // At once, but not before the connection is whole.
  server_.post([this] {
    if (!ticks_) tick();
  });
  return session;
}

void LiveSite::tick() {
  ticks_ = false;
  if (lookers_->empty()) return;
  std::map<std::string, std::shared_ptr<RobotFeed>> shown;
  for (const auto& link : robots_.all()) {
    bool wanted = false;
    for (const auto& [connection, looker] : *lookers_)
      wanted = wanted || looker.robot.empty() || looker.robot == link->robot();
    if (!wanted || link->is_gone()) continue;
    if (const auto feed = feeds_.get(link)) shown[link->robot()] = feed;
  }
  const auto now = Clock::now();
  for (auto& [connection, looker] : *lookers_) {
    std::vector<std::shared_ptr<foxglove::Robot>> robots;
    for (const auto& [name, robot] : shown)
      if (looker.robot.empty() || looker.robot == name) robots.push_back(robot);
    // What a single robot can do is said at the beginning.
    looker.begun = looker.begun || looker.robot.empty() || !robots.empty() || now - looker.since > kFirstRobot;
    if (!looker.begun) continue;
    looker.session->follow(robots);
    looker.session->tick();
  }
  for (const auto& [name, feed] : shown) feed->tick();
  ticks_ = true;
  server_.after(kPeriod, [this] { tick(); });
}

}  // namespace sinew::monitor
