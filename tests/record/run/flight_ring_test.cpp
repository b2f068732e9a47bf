#include "record/run/flight_ring.hpp"

#include <gmock/gmock.h>

#include <thread>

#include "hal/platform.hpp"
#include "midway_robot.hpp"
#include "rt/exec/real_time_executor.hpp"

namespace sinew::record::flight_ring_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Faults in one step.
class Fails final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.param("at", at_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    return step.number == static_cast<std::uint32_t>(at_) || step.number == static_cast<std::uint32_t>(at_) + 5
               ? rt::StepStatus::fault
               : rt::StepStatus::ok;
  }

 private:
  double at_ = 1e9;
};

class FlightRingOfARun : public MidwayRobot {
 protected:
  RecorderOptions with_ring(rt::Duration length = 200ms, std::size_t bytes = 4 << 20) {
    memory_.resize(bytes);
    RecorderOptions options;
    options.ring.length = length;
    options.ring.memory = memory_;
    options.ring.pixel_bytes_per_s = 1e9;
    options.ring.next_file = [this] {
      const unsigned number = ++dumps_;
      DumpFile file;
      file.path = "dump " + std::to_string(number);
      file.open = [this, number]() -> hal::Result<std::unique_ptr<hal::OutputFile>> { return disk(number); };
      file.written = [this, number]() -> hal::Result<std::unique_ptr<hal::InputFile>> {
        return std::unique_ptr<hal::InputFile>(new MemoryInput(disks[number]->bytes));
      };
      return file;
    };
    for (unsigned i = 0; i < 8; ++i) disk(i);  // no other thread makes room for them
    return options;
  }
  std::unique_ptr<RunRecorder> open_ring(RunRecorder::Pace pace, const RecorderOptions& options) {
    auto opened = RunRecorder::open(robot.build(), pace, {}, about, options);
    EXPECT_TRUE(opened);
    return std::move(*opened);
  }
  std::unique_ptr<RunRecorder> fly_ring(rt::Duration duration, const RecorderOptions& options) {
    auto recorder = open_ring(RunRecorder::Pace::waited_for, options);
    RunRecorder* const it = recorder.get();
    if (snapshot_at_.ns != 0)
      robot.grants.at(snapshot_at_, [it] { it->later([it] { EXPECT_TRUE(it->snapshot("asked")); }); });
    run(*recorder, duration);
    EXPECT_TRUE(recorder->finish());
    return recorder;
  }
  static std::pair<rt::Time, rt::Time> span_of(const Bytes& file) {
    rt::Time first{INT64_MAX}, last{0};
    auto reader = read(file);
    auto messages = reader->messages({.topics = {std::string(kStepsTopic)}});
    std::vector<LoggedStep> batch;
    for (Message m; messages.next(m) == Next::message && decode(m.data, batch);)
      for (const LoggedStep& s : batch) first = std::min(first, s.completed), last = std::max(last, s.completed);
    return {first, last};
  }

  std::vector<std::byte> memory_;
  unsigned dumps_ = 0;
  rt::Time snapshot_at_{};
};

TEST_F(FlightRingOfARun, ADumpHasTheLastSecondsAndReplaysIdentically) {
  snapshot_at_ = rt::Time{900'500'000};
  robot.grants.at(rt::Time{600'500'000}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  const auto recorder = fly_ring(1s, with_ring());
  const auto reports = recorder->ring()->reports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_TRUE(reports[0].done);
  ASSERT_TRUE(reports[0].status) << reports[0].status.error().where;
  EXPECT_EQ(reports[0].path, "dump 1");
  EXPECT_EQ(reports[0].reason, "asked");
  EXPECT_TRUE(reports[0].dumped.problems.empty());
  const Bytes& file = disks.at(1)->bytes;
  EXPECT_EQ(reports[0].dumped.bytes, file.size());
  const auto [first, last] = span_of(file);
  EXPECT_LE(first, rt::Time{last.ns - 200'000'000});
  EXPECT_GE(first, rt::Time{last.ns - 300'000'000}) << "bounded in time";
  EXPECT_GE(last, rt::Time{899'000'000});
  EXPECT_EQ(read_metadata(*read(file), "sinew.dump")["reason"], "asked");
  expect_it_says_what_is_in_it(file);
  for (const auto& v : reports[0].dumped.verdict) EXPECT_THAT(to_text(v), StartsWith("replayable from ")) << v.module;
  expect_identical(again(file));
}

TEST_F(FlightRingOfARun, NothingStandsTwiceInADump) {
  snapshot_at_ = rt::Time{500'500'000};
  fly_ring(600ms, with_ring());
  std::map<std::string, std::set<std::uint32_t>> seen;
  auto reader = read(disks.at(1)->bytes);
  auto messages = reader->messages();
  for (Message m; messages.next(m) == Next::message;)
    if (const std::string& topic = m.channel->topic; !topic.starts_with("sinew/")) {
      EXPECT_TRUE(seen[topic].insert(m.stamps.sequence).second) << topic << " " << m.stamps.sequence;
    }
  EXPECT_GT(seen["numbers.out"].size(), 200u);
}

TEST_F(FlightRingOfARun, TheSameRunGivesTheSameDump) {
  snapshot_at_ = rt::Time{500'500'000};
  fly_ring(600ms, with_ring());
  const Bytes first = disks.at(1)->bytes;
  class Again : public FlightRingOfARun {
   public:
    void TestBody() override {
      snapshot_at_ = rt::Time{500'500'000};
      fly_ring(600ms, with_ring());
    }
    const Bytes& dump() { return disks.at(1)->bytes; }
  } again;
  again.TestBody();
  EXPECT_TRUE(first == again.dump());
}

TEST_F(FlightRingOfARun, WhatHappensSoonAfterADumpIsDumpedLaterAndNothingTwice) {
  robot.add<Fails>("fails");
  robot.module("fails").params["at"] = {40.0, 0};
  robot.periodic("weak", 1, 10ms, {"fails"});
  const auto recorder = fly_ring(1s, with_ring());
  const auto reports = recorder->ring()->reports();
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_EQ(reports[0].reason, "fault of fails");
  EXPECT_THAT(reports[1].reason, ::testing::StartsWith("fault of fails at 0.4")) << "50 ms later";
  EXPECT_GE(reports[1].at - reports[0].at, 200ms);
  const auto [first, last] = span_of(disks.at(1)->bytes);
  EXPECT_GE(last, rt::Time{400'000'000}) << "the step itself is in it";
  EXPECT_LT(last, rt::Time{420'000'000});
}

TEST_F(FlightRingOfARun, AMissedDeadlineIsDumped) {
  robot.module("sums").exec = {.kind = rt::ExecModel::Kind::constant, .constant = 8ms};  // of a period of 7
  const auto recorder = fly_ring(300ms, with_ring());
  const auto reports = recorder->ring()->reports();
  ASSERT_FALSE(reports.empty());
  EXPECT_EQ(reports[0].reason, "deadline miss of slow");
  EXPECT_GT(recorder->ring()->not_dumped(), 0u);
}

TEST_F(FlightRingOfARun, ItsMemoryBoundsItAndStaysWhatItWas) {
  snapshot_at_ = rt::Time{19'900'500'000};
  const auto recorder = fly_ring(20s, with_ring(100s, 2 << 20));
  const auto reports = recorder->ring()->reports();
  ASSERT_EQ(reports.size(), 1u);
  ASSERT_TRUE(reports[0].status);
  EXPECT_EQ(memory_.size(), std::size_t{2 << 20});
  const auto [first, last] = span_of(disks.at(1)->bytes);
  EXPECT_GT(first, rt::Time{5'000'000'000}) << "what is older had to go";
  EXPECT_GE(last, rt::Time{19'899'000'000});
  expect_it_says_what_is_in_it(disks.at(1)->bytes);
  for (const auto& v : reports[0].dumped.verdict) {
    if (v.module == "looks") continue;  // its pictures are more than half of the memory
    EXPECT_THAT(to_text(v), StartsWith("replayable from ")) << v.module;
  }
}

TEST_F(FlightRingOfARun, WhatIsInMemoryCanBeDumpedByAnotherWhenTheWriterIsGone) {
  auto recorder = open_ring(RunRecorder::Pace::waited_for, with_ring());
  run(*recorder, 1s);
  const std::vector<std::byte> left = memory_;  // as a process that was killed leaves it
  recorder.reset();
  auto copy = left;
  const auto ring = RingMemory::open(copy);
  ASSERT_TRUE(ring);
  Disk out;
  DumpFile file;
  file.open = [&out]() -> hal::Result<std::unique_ptr<hal::OutputFile>> {
    return std::unique_ptr<hal::OutputFile>(new MemoryOutput(out));
  };
  file.written = [&out]() -> hal::Result<std::unique_ptr<hal::InputFile>> {
    return std::unique_ptr<hal::InputFile>(new MemoryInput(out.bytes));
  };
  Dumped dumped;
  ASSERT_TRUE(dump_ring(ring->parts(), file, "signal 9", 0, dumped));
  const auto [first, last] = span_of(out.bytes);
  EXPECT_GE(last, rt::Time{850'000'000}) << "but for the chunk that was in the writer's own memory";
  EXPECT_LE(first, rt::Time{last.ns - 150'000'000});
  expect_it_says_what_is_in_it(out.bytes);
  expect_identical(again(out.bytes));
}

TEST_F(FlightRingOfARun, MemoryOfAnythingElseIsNoRing) {
  std::vector<std::byte> memory(1 << 20, std::byte{0x5A});
  EXPECT_FALSE(RingMemory::open(memory));
  EXPECT_FALSE(RingMemory::open(std::span(memory).first(10)));
  EXPECT_EQ(RingMemory::create(std::span(memory).first(1000)).error().code, hal::Errc::bad_argument);
  auto ring = RingMemory::create(memory);
  ASSERT_TRUE(ring);
  EXPECT_TRUE(ring->parts().empty());
  ring->set_folder("runs/here");
  EXPECT_EQ(RingMemory::open(memory)->folder(), "runs/here");
  const auto parts = ring->parts();
  Dumped dumped;
  EXPECT_EQ(dump_ring(parts, {}, "", 0, dumped).error().code, hal::Errc::not_found);
}

TEST_F(FlightRingOfARun, APartThatIsFullRefusesAndKeepsWhatItHas) {
  std::vector<std::byte> memory(1 << 20);
  auto ring = RingMemory::create(memory);
  auto part = ring->next_part();
  const std::vector<std::byte> much(ring->slot_bytes() - 10, std::byte{7}), more(11);
  const std::span<const std::byte> first[] = {much}, second[] = {more};
  EXPECT_TRUE(part->append(first));
  EXPECT_EQ(part->append(second).error().detail, ENOSPC);
  ASSERT_EQ(ring->parts().size(), 1u);
  EXPECT_EQ(ring->parts()[0].size(), much.size());
  EXPECT_EQ(*part->free_bytes(), 10u);
  for (unsigned i = 1; i < 20; ++i) ring->next_part();
  EXPECT_TRUE(ring->parts().empty()) << "each on the place of the oldest, and nothing written";
}

TEST_F(FlightRingOfARun, InRealTimeADumpIsWrittenWhileTheRunGoesOn) {
  auto recorder = open_ring(RunRecorder::Pace::follows, with_ring(100ms));
  RunRecorder* const it = recorder.get();
  hal::Os& os = hal::system_os();
  ASSERT_TRUE(recorder->start(os));
  rt::RealTimeOptions how;
  how.fixed_priority = how.lock_memory = how.keep_awake = false;
  how.runner.observer = &recorder->observer();
  rt::RealTimeExecutor real(robot.graph(), os, how);
  ASSERT_TRUE(real.start());
  std::this_thread::sleep_for(400ms);
  EXPECT_TRUE(it->later([it] { static_cast<void>(it->snapshot("asked")); }));
  std::this_thread::sleep_for(200ms);
  real.stop();
  ASSERT_TRUE(recorder->finish());
  const auto reports = recorder->ring()->reports();
  ASSERT_FALSE(reports.empty());
  for (std::size_t i = 0; i < reports.size(); ++i) {
    EXPECT_TRUE(reports[i].done);
    EXPECT_TRUE(reports[i].status) << reports[i].status.error().where;
    if (i < 7) expect_it_says_what_is_in_it(disks.at(i + 1)->bytes);
  }
}

}  // namespace
}  // namespace sinew::record::flight_ring_test
