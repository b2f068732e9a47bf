#include "record/run/run_review.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "hal/platform.hpp"
#include "record/check.hpp"
#include "record/run/run_messages.hpp"
#include "recorded_robot.hpp"

namespace sinew::record::run_review_test {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A flight of 400 ms in virtual time, and the review of its file.
class RunReviewOf : public RecordedRobot {
 protected:
  RunReviewOf() {
    about.unix_ns = 1'700'000'000'000'000'000;
    robot.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  }
  std::unique_ptr<RunRecorder> fly(const RecorderOptions& options = {}, std::uint64_t room = ~std::uint64_t{0}) {
    return RecordedRobot::fly(400ms, options, room);
  }
  RunReview found(unsigned part = 0) { return review(*read(part)); }

  /// A whole file without the messages that `left_out` names, and with others changed.
  template <class F>
  Bytes without(F&& left_out, const std::optional<Metadata>& last = {}) {
    const Bytes copy = rewritten([&](const Message& m, Bytes& data) { return !left_out(m, data); }, last);
    MemoryInput whole(copy);
    EXPECT_THAT(check(whole), IsEmpty()) << "nothing is wrong with it as a file";
    return copy;
  }

  static std::vector<std::string> why_not(const RunReview& review, std::string_view module) {
    for (const ModuleVerdict& v : review.verdict)
      if (v.module == module) return v.reasons;
    return {"no such module"};
  }
  static void expect_same(const RunRecorder& recorder, const RunReview& found) {
    EXPECT_TRUE(found.is_run);
    EXPECT_TRUE(found.ended);
    ASSERT_EQ(found.verdict.size(), recorder.verdict().size());
    for (const ModuleVerdict& v : recorder.verdict()) EXPECT_EQ(why_not(found, v.module), v.reasons) << v.module;
    for (const auto& [topic, lost] : recorder.lost_messages()) {
      ASSERT_TRUE(found.lost_messages.contains(topic)) << topic;
      EXPECT_EQ(found.lost_messages.at(topic).count, lost.count) << topic;
      EXPECT_EQ(found.lost_messages.at(topic).first, lost.first) << topic;
    }
    EXPECT_EQ(found.lost_messages.size(), recorder.lost_messages().size());
    EXPECT_THAT(found.differences, IsEmpty());
  }
};

TEST_F(RunReviewOf, AWholeRunFindsEveryModuleReplayable) {
  const auto recorder = fly();
  const RunReview review = found();
  expect_same(*recorder, review);
  for (const ModuleVerdict& v : review.verdict) EXPECT_THAT(v.reasons, IsEmpty()) << v.module;
}

TEST_F(RunReviewOf, WhatWasLeftOutOnPurposeFindsWhatTheRecorderSaid) {
  const auto recorder = fly({.topics = {"numbers.out", "pictures.image"},
                             .rate_hz = {{"numbers.out", 100}, {"pictures.image", 30}},
                             .pixel_bytes_per_s = 2 * Pictures::kBytes});
  const RunReview review = found();
  expect_same(*recorder, review);
  EXPECT_THAT(why_not(review, "sums"), ElementsAre("input numbers.out at 100 Hz", "input numbers.out at 100 Hz"));
  EXPECT_THAT(why_not(review, "looks"),
              ElementsAre("input pictures.image at 30 Hz", HasSubstr("pixels of pictures.image not kept from 0.0")));
}

TEST_F(RunReviewOf, AnInputThatIsNotRecordedIsFound) {
  const auto recorder = fly({.topics = {"sums.out"}});
  const RunReview review = found();
  expect_same(*recorder, review);
  EXPECT_THAT(why_not(review, "looks"), ElementsAre("input pictures.image is not recorded"));
}

TEST_F(RunReviewOf, AFullDiskFindsTheGapsThatWereCounted) {
  const auto recorder = fly({.files = {.writer = {.chunk_bytes = 8 * 1024}}}, 60'000);
  const RunReview review = found();
  ASSERT_FALSE(recorder->lost_messages().empty());
  ASSERT_FALSE(recorder->lost_steps().empty());
  EXPECT_THAT(review.differences, IsEmpty());
  for (const auto& [topic, lost] : recorder->lost_messages())
    EXPECT_EQ(review.lost_messages.at(topic).count, lost.count) << topic;
  for (const auto& [thread, lost] : recorder->lost_steps())
    EXPECT_EQ(review.lost_steps.at(thread).count, lost.count) << thread;
  EXPECT_THAT(why_not(review, "sums"), Contains(HasSubstr("gap in numbers.out at ")));
  EXPECT_THAT(why_not(review, "numbers"), Contains(HasSubstr("gap in its steps at ")));
}

/// A driver: its raw topic is filled by its hook, and its step reads it.
class Gauge final : public rt::DriverModule {
 public:
  void declare(rt::Declaration& d) override { d.raw("raw", raw_); }
  void collect(rt::Time now) noexcept override { raw_.loan()->stamp = now; }
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }

 private:
  rt::Raw<rt::Pair> raw_;
};

void add_gauge(rt::Robot& robot) {
  robot.add<Gauge>("gauge");
  robot.periodic("gauges", 4, 2ms, {"gauge"});
}

TEST_F(RunReviewOf, MessagesOfStepsThatWereLostAreLost) {
  add_gauge(robot);
  auto opened = open(RunRecorder::Pace::follows, {.files = {.writer = {.chunk_bytes = 1024}}, .log_room = 100ms});
  std::atomic<bool> has_read = false;
  robot.grants.at(rt::Time{300'500'000}, [&] {  // its logs have been full for long
    ASSERT_TRUE(opened->later([&] { has_read = true; }));
    ASSERT_TRUE(opened->start(hal::system_os()));
    while (!has_read) std::this_thread::sleep_for(1ms);  // all of them: what comes next says what was lost
  });
  run(*opened, 400ms);
  ASSERT_TRUE(opened->finish());
  EXPECT_TRUE(opened->lost_steps().contains("fast"));
  EXPECT_TRUE(opened->lost_messages().contains("numbers.out"));
  const RunReview review = found();
  EXPECT_THAT(review.differences, IsEmpty());
  for (const std::string topic : {"numbers.out", "gauge.raw"}) {
    ASSERT_TRUE(review.lost_messages.contains(topic)) << topic;
    EXPECT_EQ(review.lost_messages.at(topic).count, opened->lost_messages().at(topic).count) << topic;
  }
  EXPECT_THAT(why_not(review, "sums"), Contains(HasSubstr("gap in numbers.out at ")));
}

TEST_F(RunReviewOf, OneMessageOfADriverTakenOutIsNamed) {
  add_gauge(robot);
  const auto recorder = fly();
  expect_same(*recorder, found());
  int n = 0;
  const Bytes copy = without([&](const Message& m, Bytes&) { return m.channel->topic == "gauge.raw" && ++n == 100; });
  const RunReview review = record::review(*read(copy));
  ASSERT_TRUE(review.lost_messages.contains("gauge.raw"));
  EXPECT_THAT(why_not(review, "gauge"), ElementsAre(HasSubstr("gap in gauge.raw at 0.198 s")));
  EXPECT_THAT(review.differences, Contains(HasSubstr("gauge.raw: 1 are missing, the file says 0")));
}

TEST_F(RunReviewOf, OneMessageTakenOutIsNamed) {
  fly();
  int n = 0;
  const Bytes copy = without([&](const Message& m, Bytes&) { return m.channel->topic == "numbers.out" && ++n == 200; });
  const RunReview review = record::review(*read(copy));
  EXPECT_THAT(
      review.differences,
      ElementsAre(HasSubstr("module sums: the file says \"replayable\", its contents \"gap in numbers.out at 0.199 s"),
                  HasSubstr("numbers.out: 1 are missing, the file says 0")));
  EXPECT_THAT(why_not(review, "numbers"), IsEmpty());
}

TEST_F(RunReviewOf, StepsTakenOutAreNamedAlsoAtTheEnd) {
  fly();
  for (const bool last : {false, true}) {
    std::size_t batches = 0, n = 0;
    const auto of_fast = [](const Message& m) {
      std::vector<LoggedStep> batch;
      return m.channel->topic == kStepsTopic && decode(m.data, batch) && batch[0].thread == 0;
    };
    static_cast<void>(without([&](const Message& m, Bytes&) {
      batches += of_fast(m);
      return false;
    }));
    ASSERT_GT(batches, 3u);
    const Bytes copy =
        without([&](const Message& m, Bytes&) { return of_fast(m) && ++n == (last ? batches : std::size_t{2}); });
    const RunReview review = record::review(*read(copy));
    ASSERT_TRUE(review.lost_steps.contains("fast"));
    EXPECT_THAT(why_not(review, "numbers"), ElementsAre(HasSubstr("gap in its steps at ")));
    EXPECT_THAT(review.differences,
                Contains(HasSubstr("thread fast: " + std::to_string(review.lost_steps.at("fast").count) +
                                   " are missing, the file says 0")));
  }
}

TEST_F(RunReviewOf, ARequestTakenOutIsAGapInTheStepsOfItsThread) {
  fly();
  const RunReview review =
      record::review(*read(without([&](const Message& m, Bytes&) { return m.channel->topic == kRequestsTopic; })));
  EXPECT_THAT(why_not(review, "numbers"), ElementsAre(HasSubstr("gap in its steps at 0.10")));
}

TEST_F(RunReviewOf, AStepThatClaimsFourBillionMessagesIsCountedAndNotGoneThrough) {
  fly();
  const std::uint32_t numbers = robot.graph().find_module("numbers");
  bool changed = false;
  const Bytes crafted = without([&](const Message& m, Bytes& data) {
    std::vector<LoggedStep> steps;
    if (changed || m.channel->topic != kStepsTopic || !decode(m.data, steps) || steps[0].module != numbers)
      return false;
    steps[0].outputs[0].count = 4'000'000'000;
    StepBatch batch;
    for (const LoggedStep& s : steps) batch.add(s);
    data.assign(batch.bytes().begin(), batch.bytes().end());
    changed = true;
    return false;
  });
  ASSERT_TRUE(changed);
  EXPECT_GT(record::review(*read(crafted)).lost_messages.at("numbers.out").count, 3'999'999'000u);
}

TEST_F(RunReviewOf, PixelsTakenOutOrChangedAreNamed) {
  fly();
  int n = 0;
  const Bytes gone =
      without([&](const Message& m, Bytes&) { return m.channel->topic == "pictures.image" && ++n == 7; });
  EXPECT_THAT(record::review(*read(gone)).differences, Contains(HasSubstr("gap in pictures.image at 0.06")));
  n = 0;
  const Bytes changed = without([&](const Message& m, Bytes& data) {
    if (m.channel->topic == "pictures.image" && ++n == 7) data.back() ^= std::byte{1};
    return false;
  });
  EXPECT_THAT(record::review(*read(changed)).differences, ElementsAre(HasSubstr("pictures.image: 1 images from 0.06")));
}

TEST_F(RunReviewOf, APartIsNotHeldAgainstTheVerdictOfTheWhole) {
  fly();
  const std::uint64_t begin = 1'700'000'000'200'000'000;
  const Bytes part = without([&](const Message& m, Bytes&) { return m.stamps.log_time < begin; },
                             Metadata{std::string(kEditedName), {{"by", "test"}}});
  const RunReview review = record::review(*read(part));
  EXPECT_TRUE(review.is_part);
  EXPECT_THAT(review.differences, IsEmpty());
  for (const ModuleVerdict& v : review.verdict) EXPECT_THAT(v.reasons, IsEmpty()) << v.module;
}

TEST_F(RunReviewOf, EveryFileOfASplitRunAgreesWithWhatIsSaidOfAll) {
  fly({.files = {.file_duration = 100ms}});
  ASSERT_GT(disks.size(), 2u);
  for (unsigned part = 0; part < disks.size(); ++part) {
    const RunReview review = found(part);
    EXPECT_EQ(review.ended, part + 1 == disks.size());
    EXPECT_THAT(review.differences, IsEmpty()) << part;
    for (const ModuleVerdict& v : review.verdict) EXPECT_THAT(v.reasons, IsEmpty()) << part << v.module;
  }
}

TEST_F(RunReviewOf, AFileThatWasCutOffHasNoVerdictToBeHeldAgainst) {
  fly({.files = {.writer = {.chunk_bytes = 8 * 1024}}});
  Bytes head(disks[0]->bytes.begin(),
             disks[0]->bytes.begin() + static_cast<std::ptrdiff_t>(disks[0]->bytes.size() / 2));
  const RunReview review = record::review(*read(head));
  EXPECT_TRUE(review.is_run);
  EXPECT_FALSE(review.ended);
  EXPECT_THAT(review.differences, IsEmpty());
}

TEST(RunReview, AnyOtherFileIsNoRun) {
  Disk disk;
  auto writer = Writer::open(std::make_unique<MemoryOutput>(disk), {});
  ASSERT_TRUE((*writer)->finish());
  FileProblem why;
  EXPECT_FALSE(review(*Reader::open(std::make_unique<MemoryInput>(disk.bytes), why)).is_run);
}

}  // namespace
}  // namespace sinew::record::run_review_test
