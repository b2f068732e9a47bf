#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "monitor/http/server.hpp"

namespace sinew::foxglove {

using monitor::Bytes;

struct Item {
  std::uint64_t time_ns = 0;
  Bytes payload{};                // may be shared with others
  std::vector<std::byte> head{};  // of the message, before the payload
};

/// What all inboxes of one connection hold together, and how its session is told that there is something.
/// Thread:  any.
class Backlog {
 public:
  explicit Backlog(std::function<void()> wake) : wake_(std::move(wake)) {}
  void tell() {
    if (told_.exchange(true)) return;
    const std::lock_guard lock(mutex_);
    if (wake_) wake_();
  }
  /// The session looks: what comes from now on is told again.
  void look() { told_.store(false); }
  /// The session ends: once this has returned, nobody is woken.
  void close() {
    const std::lock_guard lock(mutex_);
    wake_ = nullptr;
  }

  static constexpr std::size_t kMostBytes = 8 << 20;
  std::atomic<std::size_t> bytes{0};

 private:
  std::mutex mutex_;  // of wake_
  std::function<void()> wake_;
  std::atomic<bool> told_{false};
};

/// Messages of one subscription that its connection has not taken yet: the newest `most`, and only the newest one when
/// the connection's backlog is full.
/// Thread:  any.
class Inbox {
 public:
  Inbox(std::size_t most, std::shared_ptr<Backlog> backlog) : most_(most), backlog_(std::move(backlog)) {}
  ~Inbox();
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;

  void put(Item item);
  /// The oldest one.
  std::optional<Item> take();
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  void drop_oldest();

  const std::size_t most_;
  const std::shared_ptr<Backlog> backlog_;
  std::atomic<std::uint32_t> dropped_{0};
  std::mutex mutex_;  // of items_
  std::deque<Item> items_;
};

}  // namespace sinew::foxglove
