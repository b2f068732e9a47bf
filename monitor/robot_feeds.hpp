#pragma once
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "monitor/http/server.hpp"
#include "monitor/http/worker.hpp"
#include "monitor/robot_feed.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// One feed for each robot that somebody looks at, whichever way. Lets go of those that nobody looks at any more.
/// Thread:  the server's. Nothing here waits for a robot.
/// Owner:   robots and server must outlive it.
class RobotFeeds {
 public:
  RobotFeeds(Robots& robots, Server& server) : robots_(robots), server_(server) {}

  /// Null: it is being connected to, or cannot be; ask again.
  std::shared_ptr<RobotFeed> get(const std::shared_ptr<RobotLink>& link);
  /// Calls `what` once, now or later, with the feed, or with null and why.
  using WithFeed = std::function<void(const std::shared_ptr<RobotFeed>& feed, const std::string& why)>;
  void with(const std::string& robot, WithFeed what);

  static constexpr std::chrono::seconds kIdle{5};  // then a robot that nobody looks at is let go

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    std::weak_ptr<RobotLink> link{};
    std::shared_ptr<RobotFeed> feed{};
    bool opening = false;
    Clock::time_point used{}, tried{};
    std::string why{};  // there is none
    std::vector<WithFeed> waiting{};
  };
  void open(Entry& entry, const std::shared_ptr<RobotLink>& link);
  void opened(const std::string& robot, const std::shared_ptr<RobotFeed::Parts>& parts, const std::string& why);
  void let_go();

  Robots& robots_;
  Server& server_;
  // Ends feeds, whose threads have to be waited for.
  const std::shared_ptr<Worker> undertaker_ = std::make_shared<Worker>(SIZE_MAX);
  std::map<std::string, Entry> entries_;
  bool letting_go_ = false;
};

}  // namespace sinew::monitor
