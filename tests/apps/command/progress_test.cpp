#include "apps/command/progress.hpp"

#include <gtest/gtest.h>

namespace sinew::app::progress_test {
namespace {

using namespace std::chrono_literals;

ProgressState sweep(std::uint64_t done, std::uint64_t total, std::uint64_t before = 0) {
  return {.what = "sweep", .of = ProgressOf::cases, .total = total, .done = done, .done_before = before};
}

constexpr hal::Time kBegin{1'000'000'000'000};

TEST(Progress, ABarSaysHowMuchOfAFileIsDone) {
  const ProgressState half{.what = "check", .total = 2'000'000'000, .done = 1'000'000'000};
  EXPECT_EQ(progress_text(half, 10s), "check [###############               ]  50 %");
}

TEST(Progress, CasesHaveARateAndTheTimeThatIsLeft) {
  EXPECT_EQ(progress_text(sweep(496, 954), 160s), "sweep [###############               ]  52 %  3.1/s  2 min left");
  EXPECT_EQ(progress_line(sweep(496, 954), 160s), "sweep: 496 of 954 cases, 3.1/s, 2 min left");
}

TEST(Progress, TheRateIsOfThisProgramNotOfTheOneThatItGoesOnFrom) {
  EXPECT_EQ(progress_line(sweep(910, 1000, 900), 10s), "sweep: 910 of 1000 cases, 1.0/s, 90 s left");
  EXPECT_EQ(progress_line(sweep(900, 1000, 900), 10s), "sweep: 900 of 1000 cases") << "nothing is known of it yet";
}

TEST(Progress, UnitsFitWhatIsSaid) {
  EXPECT_EQ(progress_line(sweep(2000, 1'000'000), 10s), "sweep: 2000 of 1000000 cases, 200/s, 83 min left");
  EXPECT_EQ(progress_line(sweep(10, 100), 1000s), "sweep: 10 of 100 cases, 0.6/min, 2.5 h left");
  EXPECT_EQ(progress_line(sweep(1, 100), 3600s), "sweep: 1 of 100 cases, 1.0/h, 4.1 d left");
  EXPECT_EQ(progress_line(sweep(100, 100), 10s), "sweep: 100 of 100 cases, 10/s, 0 s left");
}

TEST(Progress, OnATerminalOneLineIsDrawnAgainAndErased) {
  ProgressPrinter printer("sweep", ProgressOf::cases, true, kBegin);
  printer.expect(10);
  EXPECT_EQ(printer.add(1, kBegin + 200ms), "") << "shorter work needs no words";
  EXPECT_EQ(printer.erase(), "");
  EXPECT_EQ(printer.add(4, kBegin + 1s), "\rsweep [###############               ]  50 %  5.0/s  1 s left\033[K");
  EXPECT_EQ(printer.add(1, kBegin + 1050ms), "") << "not more than ten times a second";
  EXPECT_EQ(printer.erase(), "\r\033[K");
  EXPECT_EQ(printer.erase(), "") << "it is gone";
}

TEST(Progress, InALogThereIsALineEachTenSeconds) {
  ProgressPrinter printer("sweep", ProgressOf::cases, false, kBegin);
  printer.expect(1000);
  int lines = 0;
  for (int i = 1; i <= 95; ++i) {
    const std::string text = printer.add(1, kBegin + i * 500ms);
    lines += !text.empty();
    EXPECT_EQ(text.find_first_of("\r\033"), std::string::npos);
    if (i < 20) {
      EXPECT_EQ(text, "") << "work of less than 10 s needs no words";
    } else if (i == 20) {
      EXPECT_EQ(text, "sweep: 20 of 1000 cases, 2.0/s, 8 min left\n");
    }
  }
  EXPECT_EQ(lines, 4);
  EXPECT_EQ(printer.erase(), "");
}

TEST(Progress, OfAFileALogSaysNothing) {
  ProgressPrinter printer("check", ProgressOf::parts, false, kBegin);
  printer.expect(1000);
  EXPECT_EQ(printer.add(500, kBegin + 100s), "");
}

}  // namespace
}  // namespace sinew::app::progress_test
