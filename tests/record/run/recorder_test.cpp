#include "record/run/run_recorder.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <set>
#include <thread>

#include "hal/platform.hpp"
#include "math/hash.hpp"
#include "msg/cdr.hpp"
#include "msg/compare.hpp"
#include "msg/image_buffer.hpp"
#include "msg/ros2msg.hpp"
#include "record/check.hpp"
#include "record/reader.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_review.hpp"
#include "recorded_robot.hpp"
#include "rt/exec/real_time_executor.hpp"

namespace sinew::record::recorder_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kUnix = 1'700'000'000'000'000'000;

class Recorded : public RecordedRobot {
 protected:
  Recorded() {
    about.run = {{"robot", "recorded"}};
    about.attachments.push_back({1, 2, "robot.toml", "application/toml", "text of the robot file"});
    about.unix_ns = kUnix;
  }
  std::unique_ptr<Reader> read(unsigned part = 0) {
    MemoryInput again(disks.at(part)->bytes);
    for (const FileProblem& p : check(again)) ADD_FAILURE() << to_string(p);
    return RecordedRobot::read(part);
  }
  template <class F>
  static void each(Reader& reader, std::string_view topic, F&& f) {
    auto messages = reader.messages({.topics = {std::string(topic)}, .order = Order::file});
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;) {
      ASSERT_EQ(next, Next::message) << to_string(messages.problem());
      f(m);
    }
  }
  std::uint64_t hash(std::string_view topic) { return executor->runner().topic_hash(robot.graph().find_topic(topic)); }
};

TEST_F(Recorded, EveryMessageComesBackByteForByteWithItsSequenceAndTimes) {
  fly(400ms);
  auto reader = read();
  for (const char* topic : {"numbers.out", "sums.out"}) {
    math::Hash64 h;
    std::uint32_t next = rt::kNearWrap;
    each(*reader, topic, [&](const Message& m) {
      rt::Pair pair;
      ASSERT_TRUE(msg::cdr_decode(msg::type_info<rt::Pair>(),
                                  {reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size()}, &pair));
      msg::add_to_hash(h, msg::type_info<rt::Pair>(), &pair);
      EXPECT_EQ(m.stamps.sequence, next++);
      EXPECT_EQ(m.stamps.publish_time, static_cast<std::uint64_t>(pair.stamp.ns + kUnix));
      EXPECT_GT(m.stamps.log_time, m.stamps.publish_time) << "the commit comes an execution time after the stamp";
    });
    EXPECT_EQ(h.value(), hash(topic)) << topic;
  }
}

TEST_F(Recorded, WhatWasAskedForIsInEachFileAndHowTheRunEndedBehindAllElse) {
  about.more = {{"sinew.faults", {{"000", "imu:off@3"}}}};
  auto recorder = open(RunRecorder::Pace::waited_for);
  run(*recorder, 50ms);
  ASSERT_TRUE(recorder->finish(
      {{{"end", "ended"}, {"outcome", "landed"}}, {{3, 3, "report.json", "application/json", "{\"valid\":true}"}}}));
  auto reader = read();
  EXPECT_EQ(read_metadata(*reader, "sinew.faults"), (Texts{{"000", "imu:off@3"}}));
  EXPECT_EQ(read_metadata(*reader, kResultName), (Texts{{"end", "ended"}, {"outcome", "landed"}}));
  EXPECT_EQ(read_attachment(*reader, "report.json"), "{\"valid\":true}");
  EXPECT_EQ(read_attachment(*reader, "robot.toml"), "text of the robot file");
}

TEST_F(Recorded, ARecordingOfWhichNobodySaidHowItsRunEndedHasNoResult) {
  fly(50ms);
  auto reader = read();
  EXPECT_THAT(read_metadata(*reader, kResultName), IsEmpty());
}

TEST_F(Recorded, ImagesComeBackFromTheFormThatOthersKnowAndTheirHead) {
  fly(200ms);
  auto reader = read();
  std::map<std::uint32_t, ImageHead> heads;
  each(*reader, "pictures.image/head",
       [&](const Message& m) { ASSERT_TRUE(decode(m.data, heads[m.stamps.sequence])); });
  ASSERT_EQ(heads.size(), 20u);
  math::Hash64 h;
  each(*reader, "pictures.image", [&](const Message& m) {
    const ImageHead& head = heads.at(m.stamps.sequence);
    EXPECT_TRUE(head.has_pixels);
    const auto pixels = image_pixels(m.data);
    ASSERT_TRUE(pixels);
    msg::ImageBuffer image(head.capacity_bytes);
    ASSERT_TRUE(image->format_as(static_cast<msg::PixelFormat>(head.format), head.width, head.height));
    image->stamp = head.stamp, image->exposure_ns = head.exposure_ns, image->frame_number = head.frame_number;
    std::memcpy(image->pixels(), pixels->data(), pixels->size());
    EXPECT_EQ(head_of(*image, true), head);
    msg::add_to_hash(h, msg::type_info<msg::Image>(), &*image);
  });
  EXPECT_EQ(h.value(), hash("pictures.image"));
}

TEST_F(Recorded, OfSomeThreadsKeepsTheirStepsAndOnlyWhatTheseHeld) {
  RecorderOptions some;
  some.threads = {"slow"};
  const auto recorder = fly(400ms, some);
  auto reader = read();
  std::set<std::uint32_t> held, there;
  std::vector<LoggedStep> batch;
  each(*reader, kStepsTopic, [&](const Message& m) {
    ASSERT_TRUE(decode(m.data, batch));
    for (const LoggedStep& s : batch) {
      EXPECT_EQ(robot.graph().threads()[s.thread].spec.name, "slow");
      for (const LoggedStep::Input& in : s.inputs) held.insert(in.sequences.begin(), in.sequences.end());
    }
  });
  each(*reader, "numbers.out", [&](const Message& m) { EXPECT_TRUE(there.insert(m.stamps.sequence).second); });
  EXPECT_GT(held.size(), 50u);
  EXPECT_LT(held.size(), 390u) << "the queue is too short for all 400";
  EXPECT_EQ(there, held);
  each(*reader, "pictures.image/head", [](const Message&) { ADD_FAILURE() << "nobody held it"; });
  for (const ModuleVerdict& v : recorder->verdict())
    EXPECT_EQ(to_text(v), v.module == "sums"       ? "replayable"
                          : v.module == "numbers"  ? "steps of the thread fast are not recorded"
                          : v.module == "guardian" ? "steps of the thread guardian are not recorded"
                                                   : "steps of the thread view are not recorded")
        << v.module;
  const RunReview seen = review(*reader);
  EXPECT_THAT(seen.differences, IsEmpty());
}

TEST_F(Recorded, EveryStepIsThereWithWhatItHeld) {
  robot.grants.at(rt::Time{100'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  robot.grants.at(rt::Time{200'500'000}, [this] { ASSERT_TRUE(robot.graph().set_enabled("numbers", false)); });
  robot.grants.at(rt::Time{250'500'000}, [this] { ASSERT_TRUE(robot.graph().set_enabled("numbers", true)); });
  fly(400ms);
  auto reader = read();
  std::map<std::uint32_t, std::set<std::uint64_t>> orders;  // by thread
  std::map<std::uint32_t, std::uint64_t> steps;             // by module
  std::map<std::uint32_t, std::uint64_t> dropped;
  each(*reader, kStepsTopic, [&](const Message& m) {
    std::vector<LoggedStep> batch;
    ASSERT_TRUE(decode(m.data, batch));
    EXPECT_EQ(m.stamps.log_time, static_cast<std::uint64_t>(batch.front().now.ns + kUnix));
    for (const LoggedStep& s : batch) {
      EXPECT_TRUE(orders[s.thread].insert(s.order).second);
      ++steps[s.module];
      for (const auto& in : s.inputs) dropped[s.module] += in.dropped;
      if (s.module == 1 && !s.inputs[1].sequences.empty()) {
        EXPECT_EQ(s.inputs[0].sequences.size(), 1u);
        EXPECT_LE(s.inputs[1].sequences.size(), 4u);
      }
    }
  });
  std::vector<LoggedRequest> requests;
  each(*reader, kRequestsTopic, [&](const Message& m) {
    ASSERT_TRUE(decode(m.data, requests.emplace_back()));
    EXPECT_TRUE(orders[requests.back().request.thread].insert(requests.back().order).second);
  });
  ASSERT_EQ(requests.size(), 3u);
  EXPECT_EQ(requests[0].request.kind, rt::Request::Kind::set_param);
  EXPECT_EQ(requests[0].request.value, (std::variant<bool, std::int64_t, double>(2.5)));
  EXPECT_EQ(requests[0].effect.step, 101u);
  for (std::uint32_t m = 0; m < 4; ++m) EXPECT_EQ(steps[m], executor->runner().module_stats(m).steps.value()) << m;
  for (const auto& [thread, all] : orders) EXPECT_EQ(all.size(), *all.rbegin() + 1) << "none is missing";
  EXPECT_GT(dropped[1], 0u) << "seven messages a cycle do not fit into four";
  EXPECT_EQ(dropped[1], executor->runner().topic_drops(robot.graph().find_topic("numbers.out")));
}

TEST_F(Recorded, TheBeginningSaysWhatRan) {
  auto recorder = fly(50ms);
  auto reader = read();
  std::map<std::string, Texts> metadata;
  for (const MetadataIndex& index : reader->metadata()) {
    Metadata m;
    FileProblem why;
    ASSERT_TRUE(reader->read(index, m, why)) << to_string(why);
    metadata[m.name] = m.values;
  }
  EXPECT_EQ(metadata["sinew.run"]["robot"], "recorded");
  EXPECT_EQ(metadata["sinew.run"]["unix_ns"], std::to_string(kUnix));
  EXPECT_EQ(metadata["sinew.modules"],
            (Texts{{"000", "numbers"}, {"001", "sums"}, {"002", "pictures"}, {"003", "looks"}}));
  EXPECT_EQ(metadata["sinew.threads"], (Texts{{"000", "fast"}, {"001", "slow"}, {"002", "view"}}));
  EXPECT_EQ(metadata["sinew.params"], (Texts{{"numbers.gain", "1"}}));
  EXPECT_EQ(metadata["sinew.verdict"]["looks"], "replayable");
  ASSERT_EQ(reader->attachments().size(), 1u);
  Attachment a;
  FileProblem why;
  ASSERT_TRUE(reader->read(reader->attachments()[0], a, why));
  EXPECT_EQ(a.data, "text of the robot file");
  for (const auto& [id, channel] : reader->channels()) {
    if (channel.topic != "numbers.out") continue;
    EXPECT_EQ(reader->schemas().at(channel.schema).name, "sinew_msgs/msg/Pair");
    EXPECT_EQ(reader->schemas().at(channel.schema).data, msg::ros2msg_schema(msg::type_info<rt::Pair>()));
  }
  for (const ModuleVerdict& v : recorder->verdict()) EXPECT_THAT(v.reasons, IsEmpty()) << v.module;
}

std::vector<std::string> why_not(const RunRecorder& recorder, std::string_view module) {
  for (const ModuleVerdict& v : recorder.verdict())
    if (v.module == module) return v.reasons;
  return {"no such module"};
}

TEST_F(Recorded, WhatIsLeftOutOnPurposeIsNamedInTheVerdict) {
  RecorderOptions options;
  options.topics = {"numbers.out", "pictures.image"};
  options.rate_hz = {{"numbers.out", 100}};
  options.pixel_bytes_per_s = 2 * Pictures::kBytes;
  auto recorder = fly(400ms, options);
  EXPECT_THAT(why_not(*recorder, "numbers"), IsEmpty());
  EXPECT_THAT(why_not(*recorder, "sums"), ElementsAre("input numbers.out at 100 Hz", "input numbers.out at 100 Hz"));
  EXPECT_THAT(why_not(*recorder, "looks"), ElementsAre(HasSubstr("pixels of pictures.image not kept from 0.02")));
  auto reader = read();
  std::size_t numbers = 0, pictures = 0, heads = 0;
  each(*reader, "numbers.out", [&](const Message&) { ++numbers; });
  each(*reader, "pictures.image", [&](const Message&) { ++pictures; });
  each(*reader, "pictures.image/head", [&](const Message&) { ++heads; });
  EXPECT_EQ(numbers, 40u) << "every tenth of 400";
  EXPECT_EQ(pictures, 2u) << "the rest of the second's budget is less than one more";
  EXPECT_EQ(heads, 40u) << "head and hash of each";
  each(*reader, "sums.out", [&](const Message&) { FAIL() << "not asked for"; });
}

TEST_F(Recorded, AFullDiskCostsMessagesThatAreCountedAndNamed) {
  auto recorder = fly(1s, {.files = {.writer = {.chunk_bytes = 8 * 1024}}}, 60'000);
  EXPECT_FALSE(recorder->trouble());
  ASSERT_TRUE(recorder->lost_messages().contains("numbers.out"));
  const Losses lost = recorder->lost_messages().at("numbers.out");
  std::size_t numbers = 0;
  auto reader = read();
  each(*reader, "numbers.out", [&](const Message&) { ++numbers; });
  EXPECT_EQ(numbers + lost.count, 1000u) << "each is in the file or counted";
  EXPECT_THAT(why_not(*recorder, "sums"), ::testing::Contains(HasSubstr("gap in numbers.out at ")));
}

TEST_F(Recorded, InRealTimeNobodyWaitsForADiskThatStalls) {
  auto recorder = open(RunRecorder::Pace::follows, {.files = {.writer = {.chunk_bytes = 4 * 1024}}});
  std::atomic<bool> stalls{true};
  disks[0]->on_append = [&stalls] {
    if (stalls) std::this_thread::sleep_for(100ms);
  };
  hal::Os& os = hal::system_os();
  ASSERT_TRUE(recorder->start(os));
  rt::RealTimeOptions how;
  how.fixed_priority = how.lock_memory = how.keep_awake = false;
  how.runner.observer = &recorder->observer();
  rt::RealTimeExecutor real(robot.graph(), os, how);
  ASSERT_TRUE(real.start());
  std::this_thread::sleep_for(600ms);
  real.stop();
  stalls = false;
  ASSERT_TRUE(recorder->finish());
  std::size_t numbers = 0, steps = 0;
  auto reader = read();
  each(*reader, "numbers.out", [&](const Message&) { ++numbers; });
  each(*reader, kStepsTopic, [&](const Message& m) {
    std::vector<LoggedStep> batch;
    ASSERT_TRUE(decode(m.data, batch));
    for (const LoggedStep& s : batch) steps += s.module == 0;
  });
  const auto lost = recorder->lost_messages();
  const std::uint64_t gone = lost.contains("numbers.out") ? lost.at("numbers.out").count : 0;
  const auto lost_steps = recorder->lost_steps();
  const std::uint64_t gone_steps = lost_steps.contains("fast") ? lost_steps.at("fast").count : 0;
  EXPECT_EQ(steps + gone_steps, real.runner().module_stats(0).steps.value());
  EXPECT_EQ(numbers + gone, real.runner().topic_stats(0).messages.value()) << "those of lost steps are lost, too";
}

TEST_F(Recorded, ADiskThatStallsForTwoAndAHalfSecondsLosesNothing) {
  hal::Os& os = hal::system_os();
  RecorderOptions options;
  options.disk_os = &os;
  options.log_room = robot.spec.tap_history = 1500ms;  // more than a loaded machine takes, less than the stall
  robot.spec.topics.at(0).history = 150;
  std::atomic<bool> shall_stall{false};
  disks.push_back(std::make_unique<Disk>());
  disks[0]->on_append = [&shall_stall] {
    if (shall_stall.exchange(false)) std::this_thread::sleep_for(2500ms);
  };
  auto recorder = open(RunRecorder::Pace::follows, options);
  ASSERT_TRUE(recorder->start(os));
  rt::RealTimeOptions how;
  how.fixed_priority = how.lock_memory = how.keep_awake = false;
  how.runner.observer = &recorder->observer();
  rt::RealTimeExecutor real(robot.graph(), os, how);
  ASSERT_TRUE(real.start());
  shall_stall = true;
  std::this_thread::sleep_for(4s);
  real.stop();
  ASSERT_TRUE(recorder->finish());
  ASSERT_FALSE(shall_stall) << "it has stalled";
  EXPECT_THAT(recorder->lost_steps(), IsEmpty());
  EXPECT_THAT(recorder->lost_messages(), IsEmpty());
  std::size_t numbers = 0;
  each(*read(), "numbers.out", [&](const Message&) { ++numbers; });
  EXPECT_EQ(numbers, real.runner().topic_stats(0).messages.value());
}

/// A robot that is recorded in real time, in files of a second each, on a disk that stalls from 0.7 s to 3.2 s.
class RecordedInFiles : public Recorded {
 protected:
  RecordedInFiles() {
    options.disk_os = &os;
    options.log_room = robot.spec.tap_history = 1500ms;  // as above
    options.files.file_duration = 1s;
    robot.spec.topics.at(0).history = 150;
    for (int i = 0; i < 10; ++i) disks.push_back(std::make_unique<Disk>());
    for (auto& disk : disks) disk->on_append = [this] { wait_for_the_disk(); };
  }
  void wait_for_the_disk() const {
    while (stalls) std::this_thread::sleep_for(1ms);
  }
  void fly_through_the_stall() {
    auto recorder = open(RunRecorder::Pace::follows, options);
    ASSERT_TRUE(recorder->start(os));
    rt::RealTimeOptions how;
    how.fixed_priority = how.lock_memory = how.keep_awake = false;
    how.runner.observer = &recorder->observer();
    rt::RealTimeExecutor real(robot.graph(), os, how);
    ASSERT_TRUE(real.start());
    std::this_thread::sleep_for(700ms);
    stalls = true;
    std::this_thread::sleep_for(2500ms);
    files_in_stall = recorder->progress().file->files;
    stalls = false;
    while (recorder->progress().file->files == files_in_stall) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(300ms);
    real.stop();
    ASSERT_TRUE(recorder->finish());
    EXPECT_THAT(recorder->lost_steps(), IsEmpty());
    EXPECT_THAT(recorder->lost_messages(), IsEmpty());
    files = recorder->files();
    ASSERT_LE(files, disks.size());
    for (const char* topic : {"numbers.out", "sums.out", "pictures.image"})
      sent[topic] = real.runner().topic_stats(robot.graph().find_topic(topic)).messages.value();
    steps = real.runner().module_stats(0).steps.value();
  }
  /// Every file is whole, and together they have all that was sent.
  void expect_all() {
    std::map<std::string, std::set<std::uint32_t>>
        found;  // some are in two files: steps of the later one may hold them
    std::size_t found_steps = 0;
    for (unsigned part = 0; part < files; ++part) {
      auto reader = read(part);
      for (const auto& [topic, count] : sent)
        each(*reader, topic, [&in = found[topic]](const Message& m) { in.insert(m.stamps.sequence); });
      each(*reader, kStepsTopic, [&](const Message& m) {
        std::vector<LoggedStep> batch;
        ASSERT_TRUE(decode(m.data, batch));
        for (const LoggedStep& s : batch) found_steps += s.module == 0;
      });
    }
    for (const auto& [topic, count] : sent) EXPECT_EQ(found[topic].size(), count) << topic;
    EXPECT_EQ(found_steps, steps);
    EXPECT_GT(found_steps, 0u);
  }

  hal::Os& os = hal::system_os();
  RecorderOptions options;
  std::atomic<bool> stalls{false};
  unsigned files = 0, files_in_stall = 0;
  std::map<std::string, std::uint64_t> sent;  // messages by topic
  std::uint64_t steps = 0;                    // of the first module
};

TEST_F(RecordedInFiles, NorDoesAStallInWhichAnotherFileIsDue) {
  on_open = [this] { wait_for_the_disk(); };
  fly_through_the_stall();
  EXPECT_EQ(files_in_stall, 1u) << "it goes on until the second one is there";
  expect_all();
}

TEST_F(RecordedInFiles, NorDoesAStallInWhichAFileHasItsEnd) {
  fly_through_the_stall();
  EXPECT_EQ(files_in_stall, 2u) << "the second one goes on until the first one is on the disk";
  expect_all();
}

TEST_F(Recorded, HowFarItIsIsToldWhileItWaitsForTheDisk) {
  auto recorder = open(RunRecorder::Pace::follows);
  std::atomic<bool> stalls{true}, waits{false};
  disks[0]->on_append = [&] {
    for (waits = true; stalls;) std::this_thread::sleep_for(1ms);
  };
  hal::Os& os = hal::system_os();
  ASSERT_TRUE(recorder->start(os));
  rt::RealTimeOptions how;
  how.fixed_priority = how.lock_memory = how.keep_awake = false;
  how.runner.observer = &recorder->observer();
  rt::RealTimeExecutor real(robot.graph(), os, how);
  ASSERT_TRUE(real.start());
  while (!waits) std::this_thread::sleep_for(1ms);
  const RecorderProgress progress = recorder->progress();
  ASSERT_TRUE(progress.file);
  EXPECT_EQ(progress.file->files, 1u);
  EXPECT_GT(progress.now, progress.file->began);
  real.stop();
  stalls = false;
  ASSERT_TRUE(recorder->finish());
  EXPECT_FALSE(recorder->progress().file) << "it is complete";
}

TEST_F(Recorded, ARunThatEndsWithoutAWordHasAWholeFile) {
  {
    auto recorder = open(RunRecorder::Pace::waited_for);
    run(*recorder, 50ms);
    executor.reset();
  }
  std::size_t numbers = 0;
  auto reader = read();
  EXPECT_TRUE(reader->by_summary());
  each(*reader, "numbers.out", [&](const Message&) { ++numbers; });
  EXPECT_EQ(numbers, 50u);
}

TEST_F(Recorded, SplitFilesEachSayWhatRan) {
  RecorderOptions options;
  options.files.file_duration = 100ms;
  fly(400ms, options);
  ASSERT_GT(disks.size(), 2u);
  std::set<std::uint32_t> numbers;
  for (unsigned part = 0; part < disks.size(); ++part) {
    auto reader = read(part);
    EXPECT_EQ(reader->attachments().size(), 1u);
    each(*reader, "numbers.out", [&](const Message& m) { numbers.insert(m.stamps.sequence); });
  }
  EXPECT_EQ(numbers.size(), 400u) << "some are in two files: steps of the later one may hold them";
  EXPECT_LT(disks.size(), 6u);
}

}  // namespace
}  // namespace sinew::record::recorder_test
