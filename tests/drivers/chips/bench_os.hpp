#pragma once
#include "hal/os.hpp"

namespace sinew::drivers::test {

/// Time that passes only while the caller sleeps; starts no threads.
class BenchOs final : public hal::Os {
 public:
  hal::Time now() const noexcept override { return now_; }
  void sleep_until(hal::Time t) noexcept override {
    if (t > now_) now_ = t;
  }
  void pass(hal::Duration d) { now_ = now_ + d; }
  void wait(hal::WakeWord&, std::uint32_t, hal::Time deadline) noexcept override { sleep_until(deadline); }
  void wake(hal::WakeWord&) noexcept override {}
  hal::Duration thread_cpu_time() noexcept override { return {}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions&, std::function<void()>) override {
    return hal::Error{hal::Errc::not_supported, "bench"};
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return hal::Error{hal::Errc::not_supported, "bench"};
  }
  hal::Status lock_memory() override { return {}; }

 private:
  hal::Time now_{1'000'000'000};
};

}  // namespace sinew::drivers::test
