#include "rt/exec/fp_mode.hpp"

#include <gtest/gtest.h>

#include <cfenv>

#include "graph_fixture.hpp"

namespace sinew::rt::fp_mode_test {
namespace {

volatile double g_tiny = 0x1p-1022, g_half = 0.5;

/// Spoils the mode in one of the ways that libraries do, and puts all back at the end.
class Spoiled {
 public:
  Spoiled() { std::fegetenv(&before_); }
  ~Spoiled() { std::fesetenv(&before_); }
  static void round(int mode) { std::fesetround(mode); }
  static void flush_to_zero() {
#if defined(__SSE2__)
    _mm_setcsr(_mm_getcsr() | 0x8040);
#elif defined(__aarch64__)
    asm volatile("msr fpcr, %0" ::"r"(std::uint64_t{1} << 24));
#elif defined(__mips_hard_float)
    asm volatile("ctc1 %0, $31" ::"r"(1U << 24));
#else
    std::fesetround(FE_UPWARD);
#endif
  }

 private:
  std::fenv_t before_;
};

TEST(FpMode, OfAProgramIsRight) {
  EXPECT_TRUE(FpMode::is_set());
  EXPECT_TRUE(FpMode::computes_right());
}

TEST(FpMode, OtherRoundingIsSeenByRegisterAndByResults) {
  const Spoiled spoiled;
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    Spoiled::round(mode);
    EXPECT_FALSE(FpMode::is_set()) << mode;
    EXPECT_FALSE(FpMode::computes_right()) << mode;
  }
}

TEST(FpMode, FlushingToZeroIsSeenByRegisterAndByResults) {
  const Spoiled spoiled;
  Spoiled::flush_to_zero();
  EXPECT_FALSE(FpMode::is_set());
  EXPECT_FALSE(FpMode::computes_right());
}

TEST(FpMode, SetPutsEverythingRight) {
  const Spoiled spoiled;
  Spoiled::round(FE_UPWARD);
  Spoiled::flush_to_zero();
  FpMode::set();
  EXPECT_TRUE(FpMode::is_set());
  EXPECT_TRUE(FpMode::computes_right());
}

TEST(FpMode, AScopeGivesBackWhatItFound) {
  const Spoiled spoiled;
  Spoiled::flush_to_zero();
  {
    const FpModeScope scope;
    EXPECT_TRUE(FpMode::computes_right());
  }
  EXPECT_FALSE(FpMode::is_set());
}

/// Leaves another mode behind in every step from the second on, and publishes the result of a small number in it.
class Spoiler final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    out_.loan().value[0] = g_tiny * g_half;
    if (step.number > 0) Spoiled::flush_to_zero();
    return StepStatus::ok;
  }

 private:
  Out<Pair> out_;
};

class KeepsTiny final : public Module {
 public:
  void declare(Declaration& d) override { d.in("in", in_); }
  StepStatus step(const Step&) noexcept override {
    kept += g_tiny * g_half != 0 && in_.get()->value[0] != 0 ? 1 : 0;
    return StepStatus::ok;
  }
  int kept = 0;

 private:
  In<Pair> in_;
};

TEST(FpMode, AnExecutorRunsInTheRightModeAndRepairsWhatAStepLeavesBehind) {
  const Spoiled spoiled;
  Robot robot;
  robot.add<Spoiler>("spoiler");
  KeepsTiny& keeps = robot.add<KeepsTiny>("keeps", {{"in", "spoiler.out"}});
  robot.periodic("main", 10, 1ms, {"spoiler", "keeps"});
  robot.build();
  Spoiled::flush_to_zero();
  robot.run(9500us);
  EXPECT_FALSE(FpMode::is_set()) << "the caller's own mode is given back";
  EXPECT_EQ(keeps.kept, 10);
  EXPECT_EQ(robot.stats("spoiler").fp_mode_changes.value(), 9u);
  EXPECT_EQ(robot.stats("keeps").fp_mode_changes.value(), 0u);
}

}  // namespace
}  // namespace sinew::rt::fp_mode_test
