#include "record/run/run_sink.hpp"

#include <gmock/gmock.h>

#include "midway_robot.hpp"
#include "record/check.hpp"

namespace sinew::record::run_sink_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class RunSinkMidway : public MidwayRobot {
 protected:
  /// A run of 600 ms without a file from the beginning on; one from 200 ms to 400 ms on disk 1.
  std::unique_ptr<RunRecorder> fly_with_a_file_in_the_middle(const RecorderOptions& options = {},
                                                             rt::Time begin = rt::Time{200'500'000}) {
    auto opened = RunRecorder::open(robot.build(), RunRecorder::Pace::waited_for, {}, about, options);
    EXPECT_TRUE(opened);
    std::unique_ptr<RunRecorder> recorder = std::move(*opened);
    RunRecorder* const it = recorder.get();
    robot.grants.at(begin, [this, it] {
      it->later([this, it] {
        ASSERT_TRUE(
            it->begin_file([this](unsigned) -> hal::Result<std::unique_ptr<hal::OutputFile>> { return disk(1); }));
      });
    });
    robot.grants.at(rt::Time{400'500'000}, [it] { it->later([it] { ASSERT_TRUE(it->end_file()); }); });
    run(*recorder, 600ms);
    EXPECT_TRUE(recorder->finish());
    return recorder;
  }
};

TEST_F(RunSinkMidway, AFileThatBeginsAndEndsInTheMiddleReplaysFromItsFirstStates) {
  robot.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  robot.grants.at(rt::Time{300'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 3.5)); });
  const auto recorder = fly_with_a_file_in_the_middle();
  const Bytes& file = disks.at(1)->bytes;
  EXPECT_EQ(read_metadata(*read(file), "sinew.params")["numbers.gain"], "2.5") << "of that moment";
  for (const ModuleVerdict& v : recorder->verdict()) {
    EXPECT_THAT(to_text(v), StartsWith("replayable from 0.2")) << v.module;
    ASSERT_TRUE(v.from);
    EXPECT_LT(*v.from, rt::Time{300'000'000}) << v.module << " is asked for a state, not waited for";
  }
  EXPECT_TRUE(recorder->lost_messages().empty());
  expect_it_says_what_is_in_it(file);
  const ReplayReport report = again(file);
  expect_identical(report);
  for (const auto& m : report.modules) {
    ASSERT_TRUE(m.from) << m.name;
    const auto said = recorder->verdict();
    const auto of = [&](const auto& v) { return v.module == m.name; };
    EXPECT_EQ(std::find_if(said.begin(), said.end(), of)->from, m.from) << m.name;
  }
  std::size_t plans = 0;
  auto reader = read(file);
  auto messages = reader->messages({.topics = {"plan.out"}});
  for (Message m; messages.next(m) == Next::message;) ++plans;
  EXPECT_EQ(plans, 1u) << "it was published long before, and is what `follows` latches";
}

TEST_F(RunSinkMidway, AModuleWithoutASavedStateInTheFileIsNotReplayable) {
  fly_with_a_file_in_the_middle();
  const Bytes whole = disks.at(1)->bytes;
  Disk less;
  auto writer = Writer::open(std::make_unique<MemoryOutput>(less), {});
  const auto from = read(whole);
  ASSERT_TRUE(rewrite(*from, **writer, [](const Message& m, std::vector<std::byte>& data) {
    LoggedState state;
    std::uint64_t layout = 0;
    return m.channel->topic != kStatesTopic || !decode(data, state, layout) || state.module != 0;
  }));
  ASSERT_TRUE((*writer)->finish());
  const RunReview found = review(*read(less.bytes));
  EXPECT_THAT(to_text(found.verdict.at(0)), HasSubstr("gap in its steps"));  // its state has a number in the log
  ASSERT_FALSE(found.differences.empty());
  const ReplayReport report = again(less.bytes);
  EXPECT_THAT(report.modules.at(0).stopped, HasSubstr("has no saved state of it"));
}

TEST_F(RunSinkMidway, WhatWasLatchedBeforeTheBeginningAndIsNotThereMovesTheBeginning) {
  fly_with_a_file_in_the_middle();
  Disk less;
  auto writer = Writer::open(std::make_unique<MemoryOutput>(less), {});
  const auto from = read(disks.at(1)->bytes);
  ASSERT_TRUE(rewrite(*from, **writer,
                      [](const Message& m, std::vector<std::byte>&) { return m.channel->topic != "plan.out"; }));
  ASSERT_TRUE((*writer)->finish());
  const RunReview found = review(*read(less.bytes));
  EXPECT_EQ(found.verdict.at(5).module, "follows");
  EXPECT_THAT(to_text(found.verdict.at(5)), HasSubstr("no saved state of it with all that it latched"));
}

TEST_F(RunSinkMidway, AStateBehindWhichAStepLatchedWhatIsNotThereIsNoPlaceToBegin) {
  // Each step of `sums` takes most of its period, and its queue keeps the oldest messages that come meanwhile: the step
  // after the first state latches messages from before the beginning, and from before the ones given along.
  robot.module("sums").exec = {.kind = rt::ExecModel::Kind::constant, .constant = 6500us};
  RecorderOptions options;
  options.state_every = 1ms;
  const auto recorder = fly_with_a_file_in_the_middle(options, rt::Time{201'200'000});
  const Bytes& file = disks.at(1)->bytes;
  std::vector<rt::Time> states;
  auto reader = read(file);
  auto messages = reader->messages({.topics = {std::string(kStatesTopic)}});
  LoggedState state;
  std::uint64_t layout = 0;
  for (Message m; messages.next(m) == Next::message;)
    if (decode(m.data, state, layout) && state.module == 1) states.push_back(state.completed);
  ASSERT_GT(states.size(), 2u);
  const auto verdict = recorder->verdict();
  ASSERT_TRUE(verdict.at(1).from) << to_text(verdict.at(1));
  EXPECT_GT(*verdict.at(1).from, states[0]);
  expect_it_says_what_is_in_it(file);
  expect_identical(again(file));
}

TEST_F(RunSinkMidway, OneFileAtATimeAndNoneAreErrors) {
  const auto recorder = open(RunRecorder::Pace::waited_for);
  const auto other = [this](unsigned) -> hal::Result<std::unique_ptr<hal::OutputFile>> { return disk(1); };
  EXPECT_EQ(recorder->begin_file(other).error().code, hal::Errc::busy);
  EXPECT_TRUE(recorder->end_file());
  EXPECT_EQ(recorder->end_file().error().code, hal::Errc::not_found);
  EXPECT_TRUE(recorder->begin_file(other));
  EXPECT_TRUE(recorder->finish());
  EXPECT_FALSE(recorder->later([] { FAIL(); })) << "nobody is there any more";
}

}  // namespace
}  // namespace sinew::record::run_sink_test
