#pragma once
// An operating system whose clock only the test moves: the executor's own thread runs on it, to the nanosecond.
#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "hal/platform.hpp"
#include "hal/wide.hpp"

namespace sinew::rt {

/// For graphs of one thread, which alone moves the clock. Events of the script happen on it, while it sleeps or works.
class ScriptedOs final : public hal::Os {
 public:
  // ---- the script
  void at(hal::Time t, std::function<void()> event) { script_.emplace_back(t, std::move(event)); }
  /// The sleep with this number (from 0) ends so much too late.
  void oversleep(std::uint32_t sleep, hal::Duration late) { late_[sleep] = late; }
  /// From a step: time with the processor, and time without it.
  void work(hal::Duration d) {
    cpu_ns_ += d.count();
    move_to(now() + d);
  }
  void freeze(hal::Duration d) { move_to(now() + d); }
  bool locks = true, keeps_awake = true, has_awake_means = true;
  int awake = 0;  // how often it is held now

  // ---- the system
  hal::Time now() const noexcept override { return hal::Time{now_ns_.load()}; }
  void sleep_until(hal::Time t) noexcept override {
    const auto late = late_.find(sleeps_++);
    move_to(t);
    if (late != late_.end()) move_to(now() + late->second);
    std::this_thread::yield();
  }
  void wait(hal::WakeWord& word, std::uint32_t expected, hal::Time deadline) noexcept override {
    while (word.load() == expected && now() < deadline) {
      if (!woken_once_)
        doze();
      else if (next_event() <= deadline && next_event() != hal::kNever)
        move_to(next_event());
      else if (deadline != hal::kNever)
        move_to(deadline);
      else
        doze();  // for the test to stop it
    }
    std::this_thread::yield();
  }
  /// wait() checks by itself; but before the first wake-up, the executor's start, time stands still.
  void wake(hal::WakeWord&) noexcept override { woken_once_ = true; }
  hal::Duration thread_cpu_time() noexcept override { return hal::Duration{cpu_ns_}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions& options,
                                                         std::function<void()> body) override {
    return std::unique_ptr<hal::Thread>(new ScriptedThread(options, std::move(body)));
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return hal::system_os().shared_memory(name, bytes);
  }
  hal::Status lock_memory() override {
    if (!locks) return hal::Error{hal::Errc::denied, "scripted"};
    return {};
  }
  hal::Result<std::shared_ptr<void>> keep_awake() override {
    if (!has_awake_means) return hal::Error{hal::Errc::not_found, "scripted latency"};
    if (!keeps_awake) return hal::Error{hal::Errc::denied, "scripted latency"};
    ++awake;
    return std::shared_ptr<void>(this, [](void* os) { --static_cast<ScriptedOs*>(os)->awake; });
  }

 private:
  /// Ordinary, whatever was asked for.
  class ScriptedThread final : public hal::Thread {
   public:
    ScriptedThread(const hal::ThreadOptions&, std::function<void()> body) : thread_(std::move(body)) {}
    void join() override {
      if (thread_.joinable()) thread_.join();
    }
    const std::string& shortfall() const override { return shortfall_; }

   private:
    std::string shortfall_;
    std::jthread thread_;
  };

  static void doze() {
    hal::Os& real = hal::system_os();
    real.sleep_until(real.now() + std::chrono::microseconds(100));
  }
  hal::Time next_event() const {
    hal::Time next = hal::kNever;
    for (const auto& [t, event] : script_)
      if (event) next = std::min(next, t);
    return next;
  }
  /// Events on the way happen at their instants.
  void move_to(hal::Time t) {
    while (next_event() <= t) {
      const hal::Time due = next_event();
      now_ns_.store(std::max(now_ns_.load(), due.ns));
      for (auto& [when, event] : script_)
        if (event && when == due) std::exchange(event, nullptr)();
    }
    now_ns_.store(std::max(now_ns_.load(), t.ns));
  }

  std::atomic<bool> woken_once_{false};
  hal::Wide<std::int64_t> now_ns_{1'000'000'000};
  std::int64_t cpu_ns_ = 0;
  std::uint32_t sleeps_ = 0;
  std::deque<std::pair<hal::Time, std::function<void()>>> script_;
  std::map<std::uint32_t, hal::Duration> late_;
};

}  // namespace sinew::rt
