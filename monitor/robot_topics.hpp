#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "hal/os.hpp"
#include "tap/client.hpp"

namespace sinew::monitor {

/// The topics of one running robot, read in place: the one connection that all who look at them share.
/// Thread:  any.
class RobotTopics {
 public:
  /// `client` has a reader.
  RobotTopics(std::unique_ptr<tap::Client> client, const tap::SegmentReader& reader);

  const tap::SegmentReader& reader() const { return reader_; }
  /// The robot has ended, or let go of the connection: nothing new comes.
  bool is_gone() const { return gone_.load(std::memory_order_relaxed); }

  /// One thread that waits for messages: listen(), look at everything, wait(). What happens after listen() ends wait().
  /// Thread:  one, except wake().
  class Waiter {
   public:
    explicit Waiter(RobotTopics& topics);
    ~Waiter();
    Waiter(const Waiter&) = delete;
    Waiter& operator=(const Waiter&) = delete;

    /// The topics whose messages end wait() from now on. Asks the robot, where something changes.
    void follow(std::vector<std::uint32_t> topics);
    const std::vector<std::uint32_t>& followed() const { return followed_; }  // in order, each once
    void listen();
    /// Until a message came on one of the topics, wake(), or `most` has passed; also until is_gone() changes. May
    /// return early.
    void wait(hal::Duration most = hal::Duration::max());
    /// Thread:  any.
    void wake();

   private:
    RobotTopics& topics_;
    std::vector<std::uint32_t> followed_;  // others read it with RobotTopics::mutex_
    std::vector<tap::Client::Heard> heard_;
    hal::WakeWord woken_{0};
    std::uint32_t woken_before_ = 0;
    friend class RobotTopics;
  };

 private:
  void subscribe();  // mutex_ is held
  void look_whether_it_ended();

  const std::unique_ptr<tap::Client> client_;
  const tap::SegmentReader& reader_;
  std::atomic<bool> gone_{false};
  std::mutex mutex_;  // of requests, and of the next two
  std::vector<Waiter*> waiters_;
  std::vector<std::uint32_t> subscribed_;
};

}  // namespace sinew::monitor
