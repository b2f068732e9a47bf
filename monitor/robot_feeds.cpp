#include "monitor/robot_feeds.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::monitor {
namespace {

constexpr auto kRetry = std::chrono::seconds(1);

}  // namespace

std::shared_ptr<RobotFeed> RobotFeeds::get(const std::shared_ptr<RobotLink>& link) {
  Entry& entry = entries_[link->robot()];
  const auto now = Clock::now();
  entry.used = now;
  if (!letting_go_) let_go();
  if (entry.link.lock() != link || (entry.feed && entry.feed->is_gone())) {
    entry.link = link;
    entry.feed = nullptr;
    entry.tried = {};
  }
  if (!entry.feed && !entry.opening && now - entry.tried >= kRetry) open(entry, link);
  return entry.feed;
}

void RobotFeeds::with(const std::string& robot, WithFeed what) {
  const auto link = robots_.find(robot);
  if (!link) return what(nullptr, fmt::format("no robot '{}' runs", robot));
  if (const auto feed = get(link)) return what(feed, "");
  Entry& entry = entries_[robot];
  if (!entry.opening) return what(nullptr, entry.why);
  entry.waiting.push_back(std::move(what));
}

/// Connecting waits for the robot. The link's thread must not be the last owner of the link: it only reads its name.
void RobotFeeds::open(Entry& entry, const std::shared_ptr<RobotLink>& link) {
  entry.tried = Clock::now();
  entry.why = "too many requests wait for this robot";
  Server* const server = &server_;
  entry.opening = link->post([this, server, robot = link->robot(), hello = link->hello()] {
    std::string why;  // it may just be ending: the next try sees
    auto parts = RobotFeed::connect(robot, hello, why);
    auto shared = parts ? std::make_shared<RobotFeed::Parts>(std::move(*parts)) : nullptr;
    server->post([this, robot, shared, why] { opened(robot, shared, why); });
  });
}

void RobotFeeds::opened(const std::string& robot, const std::shared_ptr<RobotFeed::Parts>& parts,
                        const std::string& why) {
  Entry& entry = entries_[robot];
  entry.opening = false, entry.why = why;
  if (parts) {
    // Some of its last owners outlive us: connections that end with their server.
    const auto bury = [weak = std::weak_ptr(undertaker_)](RobotFeed* feed) {
      const auto undertaker = weak.lock();
      if (!undertaker || !undertaker->post([feed] { delete feed; })) delete feed;
    };
    entry.feed = std::shared_ptr<RobotFeed>(new RobotFeed(std::move(*parts), entry.link), bury);
  }
  for (const auto& what : std::exchange(entry.waiting, {})) what(entry.feed, why);
}

void RobotFeeds::let_go() {
  const auto now = Clock::now();
  std::erase_if(entries_, [now](const auto& entry) {
    const Entry& e = entry.second;
    return !e.opening && now - e.used > kIdle && (!e.feed || e.feed.use_count() == 1);
  });
  letting_go_ = !entries_.empty();
  if (letting_go_) server_.after(kIdle, [this] { let_go(); });
}

}  // namespace sinew::monitor
