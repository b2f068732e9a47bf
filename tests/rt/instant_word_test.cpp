// Instants in one word: the code for machines that read 32 bits at once is tested on every machine.
#include "rt/exec/instant_word.hpp"

#include <gtest/gtest.h>

namespace sinew::rt::instant_word_test {
namespace {

using Short = InstantWord<false>;

constexpr std::int64_t kSecond = 1'000'000'000;

Time through_a_word(Time t, Time now) {
  return Short::time(Short::of(t), [now] { return now; });
}

TEST(InstantWord, ShortOneKeepsMinutesToWithin256Nanoseconds) {
  // Times since boot: seconds, and the days after which the word has gone round many times.
  for (const std::int64_t now : {std::int64_t{5}, 20 * kSecond, 86'400 * kSecond, 3'000'000 * kSecond + 12'345})
    for (const std::int64_t ago :
         {std::int64_t{0}, std::int64_t{1}, 1'000 * kSecond / 1'000'000, kSecond, 540 * kSecond}) {
      if (ago > now) continue;
      const Time t{now - ago};
      const std::int64_t late = t.ns - through_a_word(t, Time{now}).ns;
      if (t.ns >= 256) {
        EXPECT_GE(late, 0) << now << " " << ago;
      }
      EXPECT_LT(late, 256) << now << " " << ago;
      EXPECT_GE(late, -256) << now << " " << ago;  // the first 256 ns since boot share the next word
    }
}

TEST(InstantWord, ShortOneIsNeverTakenForNone) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{255}, std::int64_t{1} << 40, (std::int64_t{1} << 41) + 100})
    EXPECT_NE(Short::of(Time{ns}), Short::kNone);
}

TEST(InstantWord, WholeOneKeepsEveryNanosecondAndAsksForNoTime) {
  using Whole = InstantWord<true>;
  bool asked = false;
  const auto now = [&asked] {
    asked = true;
    return Time{};
  };
  EXPECT_EQ(Whole::time(Whole::of(Time{123'456'789'012'345}), now), Time{123'456'789'012'345});
  EXPECT_FALSE(asked);
}

}  // namespace
}  // namespace sinew::rt::instant_word_test
