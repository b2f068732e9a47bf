#include "record/run/replay.hpp"

#include <gmock/gmock.h>

#include "../../rt/graph_fixture.hpp"
#include "../memory_file.hpp"
#include "hal/silent_board.hpp"
#include "modules.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_recorder.hpp"

namespace sinew::record {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// The same robot for the run and for the replay.
void build(rt::Robot& robot) {
  robot.add<Numbers>("numbers");
  robot.add<Sums>("sums", {{"latest", "numbers.out"}, {"all", "numbers.out"}});
  robot.add<Pictures>("pictures");
  robot.add<Looks>("looks", {{"image", "pictures.image"}});
  robot.periodic("fast", 3, 1ms, {"numbers"});
  robot.periodic("slow", 2, 7ms, {"sums"});
  robot.periodic("view", 1, 10ms, {"pictures", "looks"});
  robot.spec.topics.push_back({"pictures.image", Pictures::kBytes, Pictures::kBytes, 5});
  robot.spec.robot = "replayed";
  robot.spec.seed = 7;
}

class ReplayTest : public ::testing::Test {
 protected:
  ReplayTest() { build(robot_); }

  void fly(rt::Duration duration, const RecorderOptions& options = {}) {
    robot_.configure_options.recorded = true;
    auto recorder = RunRecorder::open(
        robot_.build(), RunRecorder::Pace::waited_for,
        [this](unsigned) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
          return std::unique_ptr<hal::OutputFile>(new MemoryOutput(disk_));
        },
        {}, options);
    ASSERT_TRUE(recorder);
    robot_.grants.end = rt::Time{duration.count()};
    rt::DiscreteOptions discrete;
    discrete.observer = &(*recorder)->observer();
    rt::DiscreteExecutor executor(robot_.graph(), robot_.clock, robot_.grants, discrete);
    ASSERT_TRUE(executor.run());
    for (std::uint32_t m = 0; m < 4; ++m) steps_ += executor.runner().module_stats(m).steps.value();
    ASSERT_TRUE((*recorder)->finish());
  }

  ReplayReport again(const ReplayOptions& options = {}, double gain = 1) {
    Problem problem;
    auto reader = Reader::open(std::make_unique<MemoryInput>(disk_.bytes), problem);
    EXPECT_TRUE(reader) << to_string(problem);
    return again(*reader, options, gain);
  }
  ReplayReport again(Reader& reader, const ReplayOptions& options = {}, double gain = 1) {
    rt::Robot other;
    build(other);
    if (gain != 1) other.module("numbers").params["gain"] = {gain, 0};
    rt::Graph graph(other.spec, other.types);
    hal::SilentBoard board;
    EXPECT_TRUE(graph.configure(board));
    std::string why;
    auto report = replay(reader, graph, options, why);
    EXPECT_TRUE(report) << why;
    return report ? *report : ReplayReport{};
  }
  static const ReplayedModule& of(const ReplayReport& report, std::string_view name) {
    return *std::find_if(report.modules.begin(), report.modules.end(), [&](const auto& m) { return m.name == name; });
  }

  rt::Robot robot_;
  Disk disk_;
  std::uint64_t steps_ = 0;
};

TEST_F(ReplayTest, EveryStepOfEveryModuleGivesTheSameBytes) {
  robot_.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot_.graph().set_param("numbers", "gain", 2.5)); });
  robot_.grants.at(rt::Time{200'500'000}, [this] { ASSERT_TRUE(robot_.graph().set_enabled("numbers", false)); });
  robot_.grants.at(rt::Time{250'500'000}, [this] { ASSERT_TRUE(robot_.graph().set_enabled("numbers", true)); });
  robot_.grants.at(rt::Time{300'500'000}, [this] { ASSERT_TRUE(robot_.graph().set_period("slow", 3ms)); });
  fly(3s);
  const ReplayReport report = again();
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_TRUE(report.complete());
  EXPECT_TRUE(report.problems.empty());
  std::uint64_t steps = 0;
  for (const auto& m : report.modules) {
    steps += m.steps;
    EXPECT_EQ(m.not_compared, 0u) << m.name;
  }
  EXPECT_EQ(steps, steps_);
  EXPECT_EQ(of(report, "pictures").messages, 300u);
}

TEST_F(ReplayTest, AnotherParameterIsNamedWithStepTimeFieldAndBothValues) {
  fly(100ms);
  const ReplayReport report = again({}, 1.5);
  const ReplayDifference* d = report.first_difference();
  ASSERT_TRUE(d);
  EXPECT_EQ(d->module, "numbers");
  EXPECT_EQ(d->step, 0u);
  EXPECT_EQ(d->now, rt::Time{0});
  EXPECT_EQ(d->what, "out.value[0]");
  EXPECT_EQ(d->recorded, "1.0");
  EXPECT_EQ(d->again, "1.5");
  EXPECT_FALSE(of(report, "sums").difference) << "it is held against the record, not against what numbers gives now";
}

TEST_F(ReplayTest, BeginsAtASavedStateWithTheParametersOfThen) {
  robot_.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot_.graph().set_param("numbers", "gain", 2.5)); });
  RecorderOptions options;
  options.state_every = 50ms;
  fly(400ms, options);
  const ReplayReport all = again(), late = again({.from_s = 0.25});
  EXPECT_EQ(late.first_difference(), nullptr);
  EXPECT_TRUE(late.complete());
  for (const ReplayedModule& m : late.modules) {
    ASSERT_TRUE(m.from) << m.name;
    EXPECT_LE(*m.from, rt::Time{250'000'000});
    EXPECT_GT(*m.from, rt::Time{190'000'000});
    EXPECT_LT(m.steps, of(all, m.name).steps);
    EXPECT_GT(m.steps, of(all, m.name).steps / 3);
  }
}

TEST_F(ReplayTest, AModuleMayBeReplayedAlone) {
  fly(100ms);
  const ReplayReport report = again({.modules = {"sums"}});
  ASSERT_EQ(report.modules.size(), 1u);
  EXPECT_EQ(report.modules[0].steps, 15u);
  EXPECT_EQ(report.first_difference(), nullptr);
}

TEST_F(ReplayTest, WhatIsMissingStopsThoseWhoNeedItAndIsNamed) {
  RecorderOptions options;
  options.rate_hz = {{"numbers.out", 100}};
  options.pixel_bytes_per_s = 2 * Pictures::kBytes;
  fly(200ms, options);
  const ReplayReport report = again();
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_FALSE(report.complete());
  EXPECT_THAT(of(report, "sums").stopped, HasSubstr("input latest: message 4294967047 is not in the file"));
  EXPECT_THAT(of(report, "looks").stopped, HasSubstr("at 0.02"));
  EXPECT_THAT(of(report, "looks").stopped, HasSubstr("are not in the file"));
  EXPECT_EQ(of(report, "numbers").stopped, "");
  EXPECT_EQ(of(report, "numbers").steps, 200u);
  EXPECT_EQ(of(report, "numbers").not_compared, 180u);
  EXPECT_EQ(of(report, "pictures").not_compared, 18u);
}

/// Copies a file message by message.
void copy(Reader& from, Disk& to, const std::function<bool(const Message&, std::vector<std::byte>&)>& keep) {
  auto writer = Writer::open(std::make_unique<MemoryOutput>(to), {});
  ASSERT_TRUE(writer);
  std::map<std::uint16_t, std::uint16_t> schemas, channels;
  for (const auto& [id, s] : from.schemas()) schemas[id] = *(*writer)->add_schema(s.name, s.encoding, s.data);
  for (const auto& [id, c] : from.channels())
    channels[id] = *(*writer)->add_channel(c.topic, c.message_encoding, schemas[c.schema], c.metadata);
  for (const MetadataIndex& index : from.metadata()) {
    Metadata m;
    Problem why;
    ASSERT_TRUE(from.read(index, m, why));
    ASSERT_TRUE((*writer)->add_metadata(m));
  }
  auto messages = from.messages({.order = Order::file});
  Message m;
  while (messages.next(m) == Next::message) {
    std::vector<std::byte> data(m.data.begin(), m.data.end());
    if (!keep(m, data)) continue;
    ASSERT_TRUE((*writer)->write(channels[m.channel->id], m.stamps, data));
  }
  ASSERT_TRUE((*writer)->finish());
}

TEST_F(ReplayTest, OneFlippedBitIsNamed) {
  fly(200ms);
  Problem problem;
  auto reader = Reader::open(std::make_unique<MemoryInput>(disk_.bytes), problem);
  Disk flipped;
  std::uint32_t at = 0;
  copy(*reader, flipped, [&](const Message& m, std::vector<std::byte>& data) {
    if (m.channel->topic == "numbers.out" && ++at == 57) data[4 + 8 + 8 + 8] ^= std::byte{1};  // last bit of value[1]
    return true;
  });
  auto other = Reader::open(std::make_unique<MemoryInput>(flipped.bytes), problem);
  const ReplayReport report = again(*other);
  const ReplayDifference* d = report.first_difference();
  ASSERT_TRUE(d);
  EXPECT_EQ(d->module, "numbers");
  EXPECT_EQ(d->step, 56u);
  EXPECT_EQ(d->what, "out.value[1]");
  EXPECT_TRUE(of(report, "sums").difference) << "which has it as its input";
}

TEST_F(ReplayTest, ALostStepEndsTheModulesOfItsThread) {
  fly(200ms);
  Problem problem;
  auto reader = Reader::open(std::make_unique<MemoryInput>(disk_.bytes), problem);
  Disk shorter;
  std::uint32_t batches = 0;
  copy(*reader, shorter, [&](const Message& m, std::vector<std::byte>&) {
    std::vector<LoggedStep> steps;
    const bool fast = m.channel->topic == kStepsTopic && decode(m.data, steps) && steps[0].thread == 0;
    return !fast || ++batches != 2;
  });
  auto other = Reader::open(std::make_unique<MemoryInput>(shorter.bytes), problem);
  const ReplayReport report = again(*other);
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_THAT(of(report, "numbers").stopped, HasSubstr("the log of its thread has a gap"));
  EXPECT_EQ(of(report, "sums").stopped, "");
}

TEST_F(ReplayTest, AFileOfAnotherRobotIsRefusedInWords) {
  fly(20ms);
  Problem problem;
  auto reader = Reader::open(std::make_unique<MemoryInput>(disk_.bytes), problem);
  rt::Robot other;
  other.add<Numbers>("counter");
  other.periodic("fast", 3, 1ms, {"counter"});
  rt::Graph graph(other.spec, other.types);
  hal::SilentBoard board;
  ASSERT_TRUE(graph.configure(board));
  std::string why;
  EXPECT_FALSE(replay(*reader, graph, {}, why));
  EXPECT_EQ(why, "module 000 of the run is numbers, of the robot counter");
}

}  // namespace
}  // namespace sinew::record
