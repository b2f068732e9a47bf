// A line of a GPIO chip on a real kernel. SINEW_GPIO names a free line ("/dev/gpiochip0:5") that nothing drives,
// SINEW_GPIO_HELD a line that a kernel driver holds, SINEW_GPIO_PULSED a free line that is pulsed from outside again
// and again, for far longer than it takes to open a line. The VM bench sets them, as root; elsewhere these tests are
// skipped.
#include "hal/linux/devices/gpio.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "hal/platform.hpp"

namespace sinew::hal::gpio_test {
namespace {

using namespace std::chrono_literals;

class GpioLine : public ::testing::Test {
 protected:
  /// Whether the variable names a line; it is in `line_` then.
  bool named_by(const char* variable) {
    const char* place = std::getenv(variable);
    if (place == nullptr) return false;
    const std::string text = place;
    line_.chip = text.substr(0, text.rfind(':')), line_.line = text.substr(text.rfind(':') + 1);
    return true;
  }
  std::unique_ptr<Gpio> open(const GpioSpec& spec) {
    auto line = open_gpio(spec, why_);
    if (line) return std::move(*line);
    code_ = line.error().code;
    return nullptr;
  }
  static bool reads(Gpio& line) {
    const auto value = line.get();
    EXPECT_TRUE(value);
    return value && *value;
  }

  GpioSpec line_;
  std::string why_;
  Errc code_ = Errc::io;
};

#define SINEW_NEEDS_LINE(variable) \
  if (!named_by(variable)) GTEST_SKIP() << variable " names no line: the VM bench runs this"

TEST_F(GpioLine, AnOutputBeginsAsItIsToldAndReadsBackWhatWasSet) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  line_.output = true;
  for (const bool initial : {true, false}) {
    line_.initial = initial;
    const auto out = open(line_);
    ASSERT_TRUE(out) << why_;
    EXPECT_EQ(reads(*out), initial);
    for (const bool value : {true, false, true}) {
      ASSERT_TRUE(out->set(value));
      EXPECT_EQ(reads(*out), value);
    }
  }
}

TEST_F(GpioLine, AnActiveLowOutputIsActiveWhereTheWireIsLow) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  line_.output = line_.active_low = line_.initial = true;
  {
    const auto out = open(line_);
    ASSERT_TRUE(out) << why_;
    EXPECT_TRUE(reads(*out));
  }
  line_.output = line_.active_low = line_.initial = false;  // the chip keeps a level that nobody else drives
  {
    const auto in = open(line_);
    ASSERT_TRUE(in) << why_;
    EXPECT_FALSE(reads(*in));
  }
  line_.active_low = true;
  const auto in = open(line_);
  ASSERT_TRUE(in) << why_;
  EXPECT_TRUE(reads(*in));
}

TEST_F(GpioLine, AnInputIsNotSetAndWithoutEdgesNotWaitedFor) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  const auto in = open(line_);
  ASSERT_TRUE(in) << why_;
  const auto set = in->set(true);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, Errc::not_supported);
  const auto edge = in->wait_edge(system_os().now() + 1s);
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().code, Errc::not_supported);
}

TEST_F(GpioLine, ALineWithoutAnEdgeIsWaitedForUntilTheDeadline) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  line_.rising = line_.falling = true;
  const auto in = open(line_);
  ASSERT_TRUE(in) << why_;
  const Time deadline = system_os().now() + 20ms;
  const auto edge = in->wait_edge(deadline);
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().code, Errc::timeout);
  EXPECT_GE(system_os().now(), deadline);
}

TEST_F(GpioLine, ALineIsHeldByOneAndFreeAfterwards) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  auto first = open(line_);
  ASSERT_TRUE(first) << why_;
  EXPECT_FALSE(open(line_));
  EXPECT_EQ(code_, Errc::busy);
  EXPECT_EQ(why_, line_.chip + " line '" + line_.line + "': somebody holds it; see: gpioinfo");
  first.reset();
  EXPECT_TRUE(open(line_)) << why_;
}

TEST_F(GpioLine, ALineThatADriverHoldsIsBusy) {
  SINEW_NEEDS_LINE("SINEW_GPIO_HELD");
  for (const bool output : {false, true}) {
    line_.output = output;
    EXPECT_FALSE(open(line_));
    EXPECT_EQ(code_, Errc::busy);
    EXPECT_EQ(why_, line_.chip + " line '" + line_.line + "': somebody holds it; see: gpioinfo");
  }
}

TEST_F(GpioLine, LinesThatTheChipDoesNotHaveAreRefused) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  for (const char* none : {"8", "64", "4294967295", "KILL_SWITCH"}) {
    line_.line = none;
    EXPECT_FALSE(open(line_)) << none;
    EXPECT_EQ(code_, Errc::not_found) << none;
    EXPECT_EQ(why_, line_.chip + ": has no line '" + none + "'; its lines are 0 to 7, names: gpioinfo");
  }
}

TEST_F(GpioLine, AChipIsFoundByItsLabelAndOthersAreNamed) {
  SINEW_NEEDS_LINE("SINEW_GPIO");
  line_.chip = "no-such-label";
  EXPECT_FALSE(open(line_));
  EXPECT_EQ(code_, Errc::not_found);
  const std::string said = "gpio chip 'no-such-label': no chip has this label; there are: ";
  ASSERT_EQ(why_.substr(0, said.size()), said);
  line_.chip = why_.substr(said.size());  // there is one chip
  EXPECT_TRUE(open(line_)) << why_;
}

TEST_F(GpioLine, EdgesCarryTheKernelsStampAndOnlyThoseAskedForAreTold) {
  SINEW_NEEDS_LINE("SINEW_GPIO_PULSED");
  const auto next = [](Gpio& line, Time after) {
    const auto edge = line.wait_edge(system_os().now() + 30s);
    EXPECT_TRUE(edge);
    if (!edge) return after;
    EXPECT_GT(*edge, after);
    EXPECT_LE(*edge, system_os().now());
    return *edge;
  };
  Time last = system_os().now();
  line_.rising = true;
  {
    const auto in = open(line_);
    ASSERT_TRUE(in) << why_;
    last = next(*in, last);
    EXPECT_TRUE(reads(*in));
  }
  line_.rising = false, line_.falling = true;
  {
    const auto in = open(line_);
    ASSERT_TRUE(in) << why_;
    last = next(*in, last);
    EXPECT_FALSE(reads(*in));
  }
  line_.rising = true;
  const auto in = open(line_);
  ASSERT_TRUE(in) << why_;
  for (const bool up : {true, false}) {
    last = next(*in, last);
    EXPECT_EQ(reads(*in), up);
  }
}

}  // namespace
}  // namespace sinew::hal::gpio_test
