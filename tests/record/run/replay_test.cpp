#include "record/run/replay.hpp"

#include <gmock/gmock.h>

#include "hal/silent_board.hpp"
#include "record/run/run_messages.hpp"
#include "recorded_robot.hpp"

namespace sinew::record::replay_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class ReplayTest : public RecordedRobot {
 protected:
  ReplayReport again(const ReplayOptions& options = {}, double gain = 1) { return again(*read(), options, gain); }
  ReplayReport again(Reader& reader, const ReplayOptions& options = {}, double gain = 1) {
    rt::Robot other;
    make_robot(other);
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
};

TEST_F(ReplayTest, EveryStepOfEveryModuleGivesTheSameBytes) {
  robot.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  robot.grants.at(rt::Time{200'500'000}, [this] { ASSERT_TRUE(robot.graph().set_enabled("numbers", false)); });
  robot.grants.at(rt::Time{250'500'000}, [this] { ASSERT_TRUE(robot.graph().set_enabled("numbers", true)); });
  robot.grants.at(rt::Time{300'500'000}, [this] { ASSERT_TRUE(robot.graph().set_period("slow", 3ms)); });
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
  std::uint64_t stepped = 0;
  for (std::uint32_t m = 0; m < 4; ++m) stepped += executor->runner().module_stats(m).steps.value();
  EXPECT_EQ(steps, stepped);
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
  robot.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
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

class Drawn final : public PictureSource {
 public:
  std::span<const std::byte> pixels(std::uint32_t, const ImageHead&) override {
    return next < all.size() ? std::span<const std::byte>(all[next++]) : std::span<const std::byte>();
  }
  std::vector<Bytes> all;
  std::size_t next = 0;
};

TEST_F(ReplayTest, PixelsThatTheFileLacksComeFromASourceIfTheyHaveTheRecordedHash) {
  fly(200ms);
  Drawn drawn;
  const Bytes without = rewritten([&](const Message& m, Bytes& data) {
    if (m.channel->topic == "pictures.image/head") data.back() = std::byte{0};  // has_pixels
    if (m.channel->topic != "pictures.image") return true;
    const auto pixels = image_pixels(data);
    EXPECT_TRUE(pixels);
    drawn.all.emplace_back(pixels->begin(), pixels->end());
    return false;
  });
  EXPECT_THAT(of(again(*read(without)), "looks").stopped, HasSubstr("not in the file"));
  const ReplayReport same = again(*read(without), {.pictures = &drawn});
  EXPECT_EQ(same.pictures.same, 20u);
  EXPECT_EQ(same.pictures.first_wrong, "");
  EXPECT_TRUE(same.complete());
  EXPECT_EQ(same.first_difference(), nullptr);
  EXPECT_EQ(of(same, "looks").steps, 20u);

  drawn.next = 0;
  drawn.all[5][3] ^= std::byte{1};
  drawn.all.pop_back();
  const ReplayReport other = again(*read(without), {.pictures = &drawn});
  EXPECT_EQ(other.pictures.same, 18u);
  EXPECT_EQ(other.pictures.differing, 1u);
  EXPECT_EQ(other.pictures.missing, 1u);
  EXPECT_THAT(other.pictures.first_wrong, HasSubstr("pictures.image, image"));
  EXPECT_THAT(other.pictures.first_wrong, HasSubstr("other pixels than were seen"));
  EXPECT_THAT(of(other, "looks").stopped, HasSubstr("not in the file"));
}

TEST_F(ReplayTest, OneFlippedBitIsNamed) {
  fly(200ms);
  std::uint32_t at = 0;
  const Bytes flipped = rewritten([&](const Message& m, Bytes& data) {
    if (m.channel->topic == "numbers.out" && ++at == 57) data[4 + 8 + 8 + 8] ^= std::byte{1};  // last bit of value[1]
    return true;
  });
  const ReplayReport report = again(*read(flipped));
  const ReplayDifference* d = report.first_difference();
  ASSERT_TRUE(d);
  EXPECT_EQ(d->module, "numbers");
  EXPECT_EQ(d->step, 56u);
  EXPECT_EQ(d->what, "out.value[1]");
  EXPECT_TRUE(of(report, "sums").difference) << "which has it as its input";
}

TEST_F(ReplayTest, ALostStepEndsTheModulesOfItsThread) {
  fly(200ms);
  std::uint32_t batches = 0;
  const Bytes shorter = rewritten([&](const Message& m, Bytes&) {
    std::vector<LoggedStep> steps;
    const bool fast = m.channel->topic == kStepsTopic && decode(m.data, steps) && steps[0].thread == 0;
    return !fast || ++batches != 2;
  });
  const ReplayReport report = again(*read(shorter));
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_THAT(of(report, "numbers").stopped, HasSubstr("the log of its thread has a gap"));
  EXPECT_EQ(of(report, "sums").stopped, "");
}

TEST_F(ReplayTest, ARecordWithAnOutputThatAModuleDoesNotHaveStopsThatModule) {
  fly(100ms);
  const std::uint32_t sums = robot.graph().find_module("sums");
  const Bytes crafted = rewritten([&](const Message& m, Bytes& data) {
    std::vector<LoggedStep> steps;
    if (m.channel->topic != kStepsTopic || !decode(m.data, steps)) return true;
    StepBatch batch;
    for (LoggedStep& s : steps) {
      if (s.module == sums) s.outputs = {{.port = 1000, .first = 1, .count = 1, .origin_ns = {}}};
      batch.add(s);
    }
    data.assign(batch.bytes().begin(), batch.bytes().end());
    return true;
  });
  const ReplayReport report = again(*read(crafted));
  EXPECT_EQ(of(report, "sums").stopped, "the record has an output that this module does not have");
  EXPECT_EQ(of(report, "numbers").stopped, "");
}

TEST_F(ReplayTest, MessagesOfAnotherVersionOfATypeAreNamedAndNotUsed) {
  fly(100ms);
  const auto renamed = [](Schema& s) {
    if (s.name.ends_with("/Pair")) s.data.insert(s.data.find("value"), "other_");
  };
  const ReplayReport report = again(*read(rewritten([](const Message&, Bytes&) { return true; }, {}, renamed)));
  ASSERT_FALSE(report.problems.empty());
  EXPECT_THAT(to_string(report.problems[0]), HasSubstr("topic numbers.out: recorded with another version of "));
  EXPECT_THAT(of(report, "sums").stopped, HasSubstr("is not in the file"));
  EXPECT_EQ(of(report, "numbers").messages, 0u);
}

TEST_F(ReplayTest, OtherRemarksInADefinitionAreNoOtherVersion) {
  fly(100ms);
  const auto older = [](Schema& s) {
    if (s.name.ends_with("/Pair")) s.data.insert(s.data.find('\n', s.data.find("value")), "  # in other words");
  };
  const ReplayReport report = again(*read(rewritten([](const Message&, Bytes&) { return true; }, {}, older)));
  EXPECT_TRUE(report.problems.empty());
  EXPECT_EQ(report.first_difference(), nullptr);
  EXPECT_GT(of(report, "sums").messages, 0u);
}

TEST_F(ReplayTest, AFileOfAnotherRobotIsRefusedInWords) {
  fly(20ms);
  rt::Robot other;
  other.add<Numbers>("counter");
  other.periodic("fast", 3, 1ms, {"counter"});
  rt::Graph graph(other.spec, other.types);
  hal::SilentBoard board;
  ASSERT_TRUE(graph.configure(board));
  std::string why;
  EXPECT_FALSE(replay(*read(), graph, {}, why));
  EXPECT_EQ(why, "module 000 of the run is numbers, of the robot counter");
}

}  // namespace
}  // namespace sinew::record::replay_test
