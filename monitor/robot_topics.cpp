#include "monitor/robot_topics.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "hal/platform.hpp"

namespace sinew::monitor {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kBellPeriod = 5ms;
constexpr hal::Duration kQuiet = 200ms;  // a robot that was killed rings no bell: then its socket is looked at

void sort_once(std::vector<std::uint32_t>& topics) {
  std::sort(topics.begin(), topics.end());
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
}

}  // namespace

RobotTopics::RobotTopics(std::unique_ptr<tap::Client> client, const tap::SegmentReader& reader)
    : client_(std::move(client)), reader_(reader) {}

/// The robot keeps one list for each connection.
void RobotTopics::subscribe() {
  std::vector<std::uint32_t> all;
  for (const Waiter* w : waiters_) all.insert(all.end(), w->followed_.begin(), w->followed_.end());
  sort_once(all);
  if (all == subscribed_ || is_gone()) return;
  subscribed_ = std::move(all);
  std::vector<std::string> names;
  for (const std::uint32_t topic : subscribed_) names.push_back(reader_.topics()[topic].name);
  if (!client_->subscribe(names, kBellPeriod)) gone_.store(true, std::memory_order_relaxed);
}

void RobotTopics::look_whether_it_ended() {
  const std::lock_guard lock(mutex_);
  if (!is_gone() && client_->ended()) gone_.store(true, std::memory_order_relaxed);
}

RobotTopics::Waiter::Waiter(RobotTopics& topics) : topics_(topics) {
  const std::lock_guard lock(topics_.mutex_);
  topics_.waiters_.push_back(this);
}

RobotTopics::Waiter::~Waiter() {
  const std::lock_guard lock(topics_.mutex_);
  std::erase(topics_.waiters_, this);
  topics_.subscribe();
}

void RobotTopics::Waiter::follow(std::vector<std::uint32_t> topics) {
  sort_once(topics);
  if (topics == followed_) return;
  const std::lock_guard lock(topics_.mutex_);
  followed_ = std::move(topics);
  topics_.subscribe();
}

void RobotTopics::Waiter::listen() {
  woken_before_ = woken_.load(std::memory_order_acquire);
  heard_.clear();
  for (const std::uint32_t topic : followed_) heard_.push_back({topic, topics_.client_->bell(topic)});
}

void RobotTopics::Waiter::wait(hal::Duration most) {
  const hal::Os& os = hal::system_os();
  // Nothing of a robot that is gone, or that nobody looks at, is waited for.
  const bool is_quiet = heard_.empty() || topics_.is_gone();
  if (is_quiet) heard_.clear();
  const hal::Duration longest = is_quiet ? most : std::min(most, kQuiet);
  const hal::Time deadline = longest == hal::Duration::max() ? hal::kNever : os.now() + longest;
  topics_.client_->wait_any(heard_, {&woken_, woken_before_}, deadline);
  if (!is_quiet && longest == kQuiet && os.now() >= deadline) topics_.look_whether_it_ended();
}

void RobotTopics::Waiter::wake() {
  woken_.fetch_add(1, std::memory_order_release);
  hal::wake_shared(woken_);
}

}  // namespace sinew::monitor
