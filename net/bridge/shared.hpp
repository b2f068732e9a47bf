#pragma once
// What the threads of the bridge have in common. Inside of the room only.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "hal/clock.hpp"
#include "net/ros2/bridge_spec.hpp"

namespace sinew::net {

/// After so long each thread looks whether the robot is there.
inline constexpr hal::Duration kLongestLook = std::chrono::milliseconds(100);

/// Of one bridged topic.
struct BridgedCounts {
  std::uint64_t messages = 0;  // that went through
  std::uint64_t skipped = 0;   // with nothing to tell, or beyond the rate
  std::uint64_t refused = 0;   // that could not be translated, or that the robot did not take
  std::uint64_t lost = 0;      // gone before they were read
  std::string why{};           // of the last refusal
};

/// Thread:  any.
class BridgeShared {
 public:
  BridgeShared(std::string robot_name, ros2::BridgeSpec bridge_spec)
      : robot(std::move(robot_name)), spec(std::move(bridge_spec)) {}

  const std::string robot;
  const ros2::BridgeSpec spec;

  bool stopped() const { return stop_.load(std::memory_order_acquire); }
  void stop();
  /// Something came by DDS.
  void notify();
  /// Sleeps until notify() or stop(), which `seen` counts; at most `longest`.
  void wait(std::uint64_t& seen, hal::Duration longest);

  /// /clock was heard to say this at that time of the monotonic clock.
  void heard_clock(std::int64_t ros_ns, hal::Time at);
  /// ROS time minus the robot's, whose clock is `robot_offset_ns` ahead of the monotonic one. None: /clock is followed
  /// and was not heard in the last five seconds.
  std::optional<std::int64_t> to_ros_ns(std::int64_t robot_offset_ns) const;

  /// Changes the counts of the topic with this key of the robot file.
  template <class Change>
  void count(const std::string& key, const Change& change) {
    const std::lock_guard lock(mutex_);
    change(counts_[key]);
  }
  std::map<std::string, BridgedCounts> counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }
  void set_connected(bool connected) { connected_.store(connected, std::memory_order_relaxed); }
  bool connected() const { return connected_.load(std::memory_order_relaxed); }

 private:
  mutable std::mutex mutex_;  // of all below that are no atomics
  std::condition_variable changed_;
  std::uint64_t notes_ = 0;
  std::map<std::string, BridgedCounts> counts_;
  std::int64_t clock_offset_ns_ = 0;  // ROS time minus the monotonic clock
  std::optional<hal::Time> clock_heard_;
  std::atomic<bool> stop_{false};       // release: what was done before stop()
  std::atomic<bool> connected_{false};  // for people only
};

}  // namespace sinew::net
