// Another pace for all calls that wait.
#include "hal/scaled_os.hpp"

#include <gtest/gtest.h>

#include <random>

namespace sinew::hal::scaled_os_test {
namespace {

using namespace std::chrono_literals;

/// Remembers the calls, and stands still.
class FakeOs final : public Os {
 public:
  Time now() const noexcept override { return time; }
  void sleep_until(Time t) noexcept override { asked = t; }
  void wait(WakeWord&, std::uint32_t, Time deadline) noexcept override { asked = deadline; }
  void wake(WakeWord&) noexcept override {}
  Duration thread_cpu_time() noexcept override { return 3ms; }
  Result<std::unique_ptr<Thread>> start_thread(const ThreadOptions&, std::function<void()>) override {
    return Error{Errc::not_supported, "fake"};
  }
  Result<std::unique_ptr<SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return Error{Errc::not_supported, "fake"};
  }
  Status lock_memory() override { return {}; }
  Time time{1'000'000'000}, asked{};
};

TEST(ScaledOs, ClockStartsWhereTheOtherStandsAndRunsAtItsRate) {
  FakeOs real;
  ScaledOs half(real, 0.5);
  EXPECT_EQ(half.now(), real.time);
  real.time = real.time + 10s;
  EXPECT_EQ(half.now(), Time{1'000'000'000} + 5s);
}

TEST(ScaledOs, WaitsEndWhenItsOwnClockShowsTheDeadline) {
  FakeOs real;
  ScaledOs half(real, 0.5);
  half.sleep_until(half.now() + 1ms);
  EXPECT_EQ(real.asked, real.time + 2ms);
  WakeWord word{0};
  half.wait(word, 0, half.now() + 3ms);
  EXPECT_EQ(real.asked, real.time + 6ms);
  half.wait(word, 0, kNever);
  EXPECT_EQ(real.asked, kNever);
  EXPECT_EQ(half.thread_cpu_time(), 1500us) << "comparable with what now() has gone on";
}

TEST(ScaledOs, MayShowAnotherTime) {
  FakeOs real;
  ScaledOs past(real, 2, real.time, Time{7'000'000'000});
  EXPECT_EQ(past.now(), Time{7'000'000'000});
  past.sleep_until(Time{7'000'000'000} + 4ms);
  EXPECT_EQ(real.asked, real.time + 2ms);
}

TEST(ScaledOs, NobodyWakesBeforeItsTimeNorANanosecondLaterThanNeeded) {
  std::mt19937_64 random(1);
  for (const double rate : {0.001, 0.1, 0.3, 0.5, 0.7, 1.0, 1.7, 3.0, 10.0, 1000.0}) {
    FakeOs real;
    real.time = Time{static_cast<std::int64_t>(random() % (std::uint64_t{1} << 60))};
    const ScaledOs os(real, rate);
    for (int i = 0; i < 2000; ++i) {
      const Time t = real.time + Duration{static_cast<std::int64_t>(random() % 3'600'000'000'000)};
      const Time wake = os.unscaled(t);
      ASSERT_GE(os.scaled(wake), t) << rate;
      ASSERT_LT(os.scaled(wake + -2ns), t) << rate;
    }
  }
}

TEST(ScaledOs, TimeBeyondTheOthersReachIsNever) {
  FakeOs real;
  const ScaledOs slow(real, 0.001);
  EXPECT_EQ(slow.unscaled(Time{INT64_MAX - 1}), kNever);
}

}  // namespace
}  // namespace sinew::hal::scaled_os_test
