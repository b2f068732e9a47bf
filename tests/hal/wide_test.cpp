// 64-bit numbers between threads on machines that read 32 bits at once: this code is compiled on every machine, so it
// is tested on every machine.
#include "hal/wide.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sinew::hal::wide_test {
namespace {

TEST(WideInHalves, GivesBackWhatWasStored) {
  WideInHalves<std::int64_t> number;
  EXPECT_EQ(number.load(), 0);
  for (const std::int64_t n : {std::int64_t{1}, std::int64_t{-1}, INT64_MIN, INT64_MAX, std::int64_t{1} << 32}) {
    number.store(n);
    EXPECT_EQ(number.load(), n);
  }
  const WideInHalves<double> real(-0.125);
  EXPECT_EQ(real.load(), -0.125);
}

/// Both halves of every number are the same, so that one of two different numbers shows.
TEST(WideInHalves, NobodySeesHalfOfANumber) {
  WideInHalves<std::uint64_t> number;
  std::atomic<bool> end{false};
  std::thread writer([&] {
    for (std::uint64_t n = 0; !end.load(); ++n) number.store((n & 0xFFFFFFFF) << 32 | (n & 0xFFFFFFFF));
  });
  std::uint64_t torn = 0, backwards = 0, before = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t n = number.load();
    torn += n >> 32 != (n & 0xFFFFFFFF);
    backwards += n < before;
    before = n;
  }
  end = true;
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
}

TEST(TallyInHalves, CountsAcrossEveryChangeOfTheUpperWord) {
  TallyInHalves tally;
  std::uint64_t sum = 0;
  for (const std::uint32_t more : {0x7FFFFFFFu, 1u, 0x7FFFFFFFu, 1u, 0x80000000u, 5u, 0x80000000u, 0xFFFFFFFFu, 0u}) {
    tally.add(more);
    sum += more;
    EXPECT_EQ(tally.value(), sum);
  }
}

/// Each round passes one change of the upper word; two of them within an instant would need 2^31 counts in it.
TEST(TallyInHalves, NothingIsLostBetweenThreadsAndNobodySeesItFall) {
  constexpr std::uint32_t kAdds = 2'000;
  for (const std::uint32_t halves : {1u, 2u, 3u}) {
    TallyInHalves tally;
    for (std::uint32_t i = 0; i < halves; ++i) tally.add(0x80000000u);
    const std::uint64_t begin = tally.value() + 0x80000000u - 1'000, end = begin + std::uint64_t{3} * kAdds;
    tally.add(0x80000000u - 1'000);
    std::vector<std::thread> adders;
    for (int i = 0; i < 3; ++i)
      adders.emplace_back([&] {
        for (std::uint32_t n = 0; n < kAdds; ++n) tally.add();
      });
    std::uint64_t fell = 0, before = begin;
    while (before < end) {
      const std::uint64_t now = tally.value();
      fell += now < before || now > end;
      before = now;
    }
    for (auto& adder : adders) adder.join();
    EXPECT_EQ(tally.value(), end);
    EXPECT_EQ(fell, 0u);
  }
}

TEST(Wide, IsWithoutALockOnThisMachine) {
  EXPECT_TRUE(std::atomic<std::uint32_t>::is_always_lock_free);
  Wide<double> number(2.5);
  number.store(number.load() * 2);
  EXPECT_EQ(number.load(), 5.0);
  Tally tally;
  tally.add(3);
  EXPECT_EQ(tally.value(), 3u);
}

}  // namespace
}  // namespace sinew::hal::wide_test
