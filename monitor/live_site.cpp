#include "monitor/live_site.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::monitor {
namespace {

constexpr auto kRetry = std::chrono::seconds(1);

std::string new_id() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

}  // namespace

LiveSite::LiveSite(Robots& robots, Server& server) : robots_(robots), server_(server), id_(new_id()) {}

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
  host.closed = [this, connection] { lookers_.erase(connection); };
  auto session = std::make_unique<foxglove::Session>(std::move(options), std::move(host));
  lookers_[connection] = {session.get(), robot, Clock::now()};
  // At once, but not before the connection is whole.
  server_.post([this] {
    if (!ticks_) tick();
  });
  return session;
}

void LiveSite::tick() {
  ticks_ = false;
  const auto links = robots_.all();
  std::map<std::string, std::shared_ptr<foxglove::Robot>> shown;
  for (const auto& link : links) {
    bool wanted = false;
    for (const auto& [connection, looker] : lookers_)
      wanted = wanted || looker.robot.empty() || looker.robot == link->robot();
    if (!wanted || link->is_gone()) continue;
    if (const auto feed = feed_of(link)) shown[link->robot()] = feed;
  }
  const auto now = Clock::now();
  for (auto& [connection, looker] : lookers_) {
    std::vector<std::shared_ptr<foxglove::Robot>> robots;
    for (const auto& [name, robot] : shown)
      if (looker.robot.empty() || looker.robot == name) robots.push_back(robot);
    // What a single robot can do is said at the beginning.
    looker.begun = looker.begun || looker.robot.empty() || !robots.empty() || now - looker.since > kFirstRobot;
    if (!looker.begun) continue;
    looker.session->follow(robots);
    looker.session->tick();
  }
  for (auto at = feeds_.begin(); at != feeds_.end();) {
    Feed& entry = at->second;
    if (shown.contains(at->first)) entry.feed->tick();
    if (entry.opening || now - entry.used <= kFeedIdle)
      ++at;
    else
      at = feeds_.erase(at);
  }
  if (lookers_.empty() && feeds_.empty()) return;
  ticks_ = true;
  server_.after(kPeriod, [this] { tick(); });
}

/// Null: it is being connected to, or cannot be.
std::shared_ptr<RobotFeed> LiveSite::feed_of(const std::shared_ptr<RobotLink>& link) {
  Feed& entry = feeds_[link->robot()];
  const auto now = Clock::now();
  entry.used = now;
  if (entry.link.lock() != link || (entry.feed && entry.feed->is_broken())) {
    entry.link = link;
    entry.feed = nullptr;
    entry.tried = {};
  }
  if (entry.feed || entry.opening || now - entry.tried < kRetry) return entry.feed;
  entry.tried = now;
  Server* const server = &server_;
  // Connecting waits for the robot. The link's thread must not be the last owner of the link: it only reads its name.
  entry.opening = link->post([this, server, robot = link->robot(), hello = link->hello()] {
    std::string why;  // it may just be ending: the next try sees
    auto parts = RobotFeed::connect(robot, hello, why);
    auto shared = parts ? std::make_shared<RobotFeed::Parts>(std::move(*parts)) : nullptr;
    server->post([this, robot, shared] { opened(robot, shared); });
  });
  return nullptr;
}

void LiveSite::opened(const std::string& robot, const std::shared_ptr<RobotFeed::Parts>& parts) {
  const auto at = feeds_.find(robot);
  if (at == feeds_.end()) return;
  at->second.opening = false;
  if (!parts) return;
  // Its threads may wait for the robot when it ends.
  const auto bury = [this](RobotFeed* feed) {
    if (!undertaker_.post([feed] { delete feed; })) delete feed;
  };
  at->second.feed = std::shared_ptr<RobotFeed>(new RobotFeed(std::move(*parts), at->second.link), bury);
}

}  // namespace sinew::monitor
