#include "monitor/http/worker.hpp"

#include <utility>

namespace sinew::monitor {

Worker::~Worker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  posted_.notify_one();
  thread_.join();
}

bool Worker::post(std::function<void()> what) {
  {
    const std::lock_guard lock(mutex_);
    if (stop_ || waiting_.size() >= most_waiting_) return false;
    waiting_.push_back(std::move(what));
  }
  posted_.notify_one();
  return true;
}

void Worker::serve() {
  std::unique_lock lock(mutex_);
  while (true) {
    posted_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    auto what = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    what();
    what = nullptr;  // what it holds may wait, too
    lock.lock();
  }
}

}  // namespace sinew::monitor
