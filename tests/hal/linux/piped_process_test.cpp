#include "hal/linux/piped_process.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

namespace sinew::hal::piped_process_test {
namespace {

struct Heard {
  std::string out, err;
  PipedIo io(std::function<std::string_view()> input = {}) {
    return {std::move(input), [this](std::string_view t) { out += t; }, [this](std::string_view t) { err += t; }};
  }
};

TEST(PipedProcess, OutputAndErrorsComeApartAndTheExitCodeIsAnswered) {
  Heard heard;
  const auto code = run_piped({"sh", "-c", "echo out; echo err >&2; exit 7"}, heard.io());
  ASSERT_TRUE(code);
  EXPECT_EQ(*code, 7);
  EXPECT_EQ(heard.out, "out\n");
  EXPECT_EQ(heard.err, "err\n");
}

TEST(PipedProcess, MegabytesGoThroughInBothDirectionsAtOnce) {
  const std::string piece(100'000, 'x');
  int left = 50;
  Heard heard;
  const auto code = run_piped({"cat"}, heard.io([&]() -> std::string_view {
    return left-- > 0 ? std::string_view(piece) : std::string_view();
  }));
  ASSERT_TRUE(code);
  EXPECT_EQ(*code, 0);
  EXPECT_EQ(heard.out.size(), 5'000'000u);
  EXPECT_EQ(std::count(heard.out.begin(), heard.out.end(), 'x'), 5'000'000);
}

TEST(PipedProcess, WithoutInputItReadsAnEnd) {
  Heard heard;
  const auto code = run_piped({"cat"}, heard.io());
  ASSERT_TRUE(code);
  EXPECT_EQ(*code, 0);
}

TEST(PipedProcess, InputThatNobodyReadsEndsNobody) {
  const std::string piece(100'000, 'x');
  int left = 50;
  Heard heard;
  const auto code = run_piped({"sh", "-c", "exit 3"}, heard.io([&]() -> std::string_view {
    return left-- > 0 ? std::string_view(piece) : std::string_view();
  }));
  ASSERT_TRUE(code);
  EXPECT_EQ(*code, 3);
  EXPECT_GT(left, 0) << "it was dropped, not pushed";
}

TEST(PipedProcess, AKilledProgramAnswersItsSignal) {
  const auto code = run_piped({"sh", "-c", "kill -9 $$"}, {});
  ASSERT_TRUE(code);
  EXPECT_EQ(*code, 128 + SIGKILL);
}

TEST(PipedProcess, AProgramThatIsNotThereIsNotFound) {
  const auto named = run_piped({"no-such-program-anywhere"}, {});
  ASSERT_FALSE(named);
  EXPECT_EQ(named.error().code, Errc::not_found);
  const auto folder = run_piped({"/"}, {});
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, Errc::denied);
}

}  // namespace
}  // namespace sinew::hal::piped_process_test
