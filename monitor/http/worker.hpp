#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace sinew::monitor {

/// A thread that does one piece of work after the other: what waits for a robot must not wait on the server's thread.
/// Thread:  any.
class Worker {
 public:
  explicit Worker(std::size_t most_waiting) : most_waiting_(most_waiting), thread_([this] { serve(); }) {}
  ~Worker();  // does first what waits
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// False: too much waits already.
  bool post(std::function<void()> what);

 private:
  void serve();

  const std::size_t most_waiting_;
  std::mutex mutex_;  // of the next three
  std::condition_variable posted_;
  std::deque<std::function<void()>> waiting_{};
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace sinew::monitor
