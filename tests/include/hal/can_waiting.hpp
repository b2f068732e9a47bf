#pragma once
// What tests of CAN transports share: a watch, and reading with a deadline that only a broken bus reaches.
#include <gtest/gtest.h>

#include "hal/can_bus.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {

inline constexpr Duration kPatience = std::chrono::seconds(10);

class Bell final : public Wake {
 public:
  void wake() noexcept override {
    word_.fetch_add(1, std::memory_order_release);
    system_os().wake(word_);
  }
  std::uint32_t times() const { return word_.load(std::memory_order_acquire); }
  void wait_beyond(std::uint32_t seen, Time deadline) { system_os().wait(word_, seen, deadline); }

 private:
  WakeWord word_{0};
};

inline std::shared_ptr<FdWatch> start_watch() {
  ThreadOptions options;
  options.name = "watch";
  auto watch = FdWatch::start(system_os(), options);
  EXPECT_TRUE(watch);
  return watch ? *watch : nullptr;
}

/// Tries again every millisecond until `done` or the patience is over.
template <class Done>
bool eventually(Done done) {
  const Time deadline = system_os().now() + kPatience;
  while (!done()) {
    if (system_os().now() >= deadline) return false;
    system_os().sleep_until(system_os().now() + std::chrono::milliseconds(1));
  }
  return true;
}

/// The next frame. Waits on while the bus is closed.
inline ::testing::AssertionResult next_frame(CanBus& bus, msg::CanFrame& out) {
  Error last{};
  const bool got = eventually([&] {
    const auto read = bus.read(out);
    if (!read) last = read.error();
    return read && *read;
  });
  if (got) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "no frame; last error: " << to_string(last.code) << " " << last.where;
}

}  // namespace sinew::hal
