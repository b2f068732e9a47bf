#pragma once
// The system under the test as an Os that is watched: how long the executor asks to sleep, and that its threads call
// nothing beside the Os.
#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "hal/platform.hpp"
#include "rt/trap.hpp"

namespace sinew::rt {

class ProbeOs final : public hal::Os {
 public:
  hal::Time now() const noexcept override {
    const trap::Scope outside(nullptr);
    return os_.now();
  }
  void sleep_until(hal::Time t) noexcept override {
    const trap::Scope outside(nullptr);
    note_sleep(t);
    os_.sleep_until(t);
  }
  void wait(hal::WakeWord& word, std::uint32_t expected, hal::Time deadline) noexcept override {
    const trap::Scope outside(nullptr);
    os_.wait(word, expected, deadline);
  }
  void wake(hal::WakeWord& word) noexcept override {
    const trap::Scope outside(nullptr);
    os_.wake(word);
  }
  hal::Duration thread_cpu_time() noexcept override {
    const trap::Scope outside(nullptr);
    return os_.thread_cpu_time();
  }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions& options,
                                                         std::function<void()> body) override {
    if (threads_ > 0) os_.sleep_until(os_.now() + before_further_threads);
    auto& calls = calls_[threads_++];
    return os_.start_thread(options, [&calls, body = std::move(body)] {
      const trap::Scope scope("an executor's loop", &calls);
      body();
    });
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return os_.shared_memory(name, bytes);
  }
  hal::Status lock_memory() override {
    if (denies) return hal::Error{hal::Errc::denied, "probe"};
    return {};  // not really: it would stay for all tests of the program
  }

  /// Longest of the sleeps that only time can end. Thread: any.
  hal::Duration longest_sleep() const { return hal::Duration{longest_ns_.load()}; }
  /// Trapped calls of executor threads outside of the Os; after they have ended.
  std::uint32_t calls() const {
    std::uint32_t sum = 0;
    for (const std::uint32_t c : calls_) sum += c;
    return sum;
  }
  bool denies = false;
  hal::Duration before_further_threads{0};  // so long a thread that is there already waits for the next one

 private:
  void note_sleep(hal::Time t) noexcept {
    const auto ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>((t - os_.now()).count(), 0, UINT32_MAX));
    std::uint32_t longest = longest_ns_.load();
    while (ns > longest && !longest_ns_.compare_exchange_weak(longest, ns)) {
    }
  }

  hal::Os& os_ = hal::system_os();
  std::atomic<std::uint32_t> longest_ns_{0};  // 4 s are long enough
  std::array<std::uint32_t, 16> calls_{};
  std::size_t threads_ = 0;
};

}  // namespace sinew::rt
