#include "monitor/robots.hpp"

#include <algorithm>
#include <utility>

#include "tap/names.hpp"

namespace sinew::monitor {

Robots::Robots() {
  look();
  thread_ = std::thread([this] {
    std::unique_lock lock(mutex_);
    while (!stopped_.wait_for(lock, kPeriod, [this] { return stop_; })) {
      lock.unlock();
      look();
      lock.lock();
    }
  });
}

Robots::~Robots() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stopped_.notify_one();
  thread_.join();
}

void Robots::look() {
  const std::lock_guard looking(looking_);
  std::string why;
  const auto running = tap::running(why);
  std::map<std::string, std::shared_ptr<RobotLink>> before, now;
  {
    const std::lock_guard lock(mutex_);
    before = links_;
  }
  if (running)
    for (const tap::Running& r : *running) {
      const auto known = before.find(r.robot);
      if (known != before.end() && known->second->holder() == r.pid && !known->second->is_gone()) {
        now.insert(*known);
        continue;
      }
      std::string not_yet;  // it may just be starting or ending: the next look sees
      if (auto client = tap::Client::connect(r.robot, not_yet))
        now.emplace(r.robot, std::make_shared<RobotLink>(r.robot, r.pid, std::move(*client)));
    }
  {
    const std::lock_guard lock(mutex_);
    links_.swap(now);
    problem_ = running ? "" : why;
  }
  // Links that are no more end here, outside of the lock: their threads may be waiting for an answer.
}

std::vector<std::shared_ptr<RobotLink>> Robots::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<RobotLink>> list;
  for (const auto& [name, link] : links_) list.push_back(link);
  return list;
}

std::shared_ptr<RobotLink> Robots::find(const std::string& robot) const {
  const std::lock_guard lock(mutex_);
  const auto found = links_.find(robot);
  return found == links_.end() ? nullptr : found->second;
}

std::string Robots::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

}  // namespace sinew::monitor
