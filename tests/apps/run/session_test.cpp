// A run from its beginning to its exit code, on a board that the test controls.
#include "apps/run/session.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>

#include "apps/command/command.hpp"
#include "hal/linux/socket.hpp"

namespace sinew::app::session_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The events in their order; a step may add to them, too, as this allocates nothing.
struct Events {
  std::array<const char*, 16> text{};
  std::atomic<std::size_t> count{0};
  void add(const char* event) { text.at(count.fetch_add(1)) = event; }
  std::vector<std::string> all() const { return {text.begin(), text.begin() + count.load()}; }
} happened;
std::vector<std::string> events() { return happened.all(); }

class Ticker final : public rt::Module {
 public:
  void declare(rt::Declaration&) override {}
  rt::StepStatus step(const rt::Step&) noexcept override {
    if (++steps_ == 1) happened.add("first step");
    return rt::StepStatus::ok;
  }

 private:
  int steps_ = 0;
};

class ToldBoard final : public RunBoard, public hal::GrantSource {
 public:
  std::string name() const override { return "none"; }
  bool open(RunContext&, std::string& why) override {
    why = "it is not plugged in";
    return opens;
  }
  hal::Board& devices() override { return none_; }
  hal::GrantSource& grants() override { return *this; }
  std::string why_no_grant(const hal::Error&) const override { return "the world broke"; }
  bool start(RunContext&, std::string& why) override {
    happened.add("board starts");
    why = "it does not start";
    return starts;
  }
  bool over(RunContext& run, hal::Time now) override { return !run.options.virtual_time && now - run.begin > 50ms; }
  void end(RunContext&) override { happened.add("good-bye"); }
  int report(RunContext&, RunSummary& summary) override {
    happened.add("report");
    if (!timing.reasons.empty()) summary.timing(timing);
    return summary.finish("as told", code);
  }
  hal::Result<hal::Time> next_grant(hal::Time done) override {
    if (done >= hal::Time{} + 10ms) return hal::Error{fails ? hal::Errc::io : hal::Errc::closed, "no more"};
    return done + 1ms;
  }

  bool opens = true, starts = true, fails = false;
  int code = 0;
  TimingVerdict timing{};

 private:
  hal::EmptyBoard none_;
};

class SessionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    happened.count = 0;
    file_ =
        (std::filesystem::temp_directory_path() / ("sinew_session_" + std::to_string(::getpid()) + ".toml")).string();
    std::ofstream(file_) << R"([robot]
name = "told"
board = "none"
[module.tick]
type = "Ticker"
exec_us = 10
[[thread]]
name = "loop"
period_us = 1000
priority = 10
order = ["tick"]
)";
    options_.robot = file_;
    options_.quiet = options_.no_record = true;
    types_.add<Ticker>("Ticker");
  }
  void TearDown() override { std::filesystem::remove(file_); }

  int run(ParentLine* parent = nullptr) {
    auto prepared = prepare(options_, types_);
    if (!prepared) return -1;
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const int code = run_session(*prepared, options_, board_, parent, std::nullopt);
    said_ = testing::internal::GetCapturedStderr();
    told_ = testing::internal::GetCapturedStdout();
    return code;
  }

  std::string file_, said_, told_;
  RunOptions options_;
  rt::ModuleTypes types_;
  ToldBoard board_;
};

TEST_F(SessionTest, InRealTimeTheBoardStartsBeforeTheFirstStepAndReportsAfterItsGoodBye) {
  board_.code = 1;
  EXPECT_EQ(run(), 1) << said_;
  EXPECT_THAT(events(), ElementsAre("board starts", "first step", "good-bye", "report"));
}

TEST_F(SessionTest, InVirtualTimeToo) {
  options_.virtual_time = true;
  EXPECT_EQ(run(), 0) << said_;
  EXPECT_THAT(events(), ElementsAre("board starts", "first step", "good-bye", "report"));
}

TEST_F(SessionTest, ATimingThatIsNoMeasurementFailsAStrictRunOnly) {
  board_.timing = {.reasons = {"late"}, .worst = "late", .what_to_do = ""};
  EXPECT_EQ(run(), 0) << said_;
  options_.strict = true;
  const int code = run();
  if (said_.find("--strict: not started") != std::string::npos) GTEST_SKIP() << "this machine: " << said_;
  EXPECT_EQ(code, 1) << said_;
  EXPECT_EQ(told_, "mission   as told\n") << "which was good";
}

TEST_F(SessionTest, WhatCannotBeBegunIsTwoAndMovesNothing) {
  for (const bool virtual_time : {false, true}) {
    options_.virtual_time = virtual_time;
    happened.count = 0;
    board_.starts = false;
    EXPECT_EQ(run(), kNotBegun);
    EXPECT_THAT(events(), ElementsAre("board starts"));
    EXPECT_THAT(said_, HasSubstr("it does not start"));
    board_.opens = false;
    EXPECT_EQ(run(), kNotBegun);
    EXPECT_THAT(said_, HasSubstr("it is not plugged in"));
    board_.opens = board_.starts = true;
  }
}

TEST_F(SessionTest, ABoardThatDoesNotStartIsNoFaultForTheParent) {
  auto line = hal::stream_pair();
  ASSERT_TRUE(line);
  ParentLine parent(std::move(line->second));
  board_.starts = false;
  EXPECT_EQ(run(&parent), kNotBegun);
  std::array<std::byte, 1> word{};
  const auto heard = line->first->read_now(word);
  EXPECT_EQ(heard ? *heard : 0, 0u) << "the parent was told to watch: what ends now looks like a death to it";
}

TEST_F(SessionTest, AWorldThatBreaksIsAFailedRunWithItsWordsWhateverTheBoardReports) {
  options_.virtual_time = true;
  board_.fails = true;
  EXPECT_EQ(run(), kFailed);
  EXPECT_EQ(told_, "mission   as told, but the world broke at 0.0 s\n");
  EXPECT_THAT(events(), ElementsAre("board starts", "first step", "good-bye", "report"));
}

}  // namespace
}  // namespace sinew::app::session_test
