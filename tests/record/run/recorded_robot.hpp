#pragma once
#include <gtest/gtest.h>

#include "../../rt/graph_fixture.hpp"
#include "../memory_file.hpp"
#include "../rewrite.hpp"
#include "modules.hpp"
#include "record/run/run_recorder.hpp"

namespace sinew::record {

/// The recorded robot: a thread of numbers, a thread that sums them with too short a queue, and a thread of pictures.
inline void make_robot(rt::Robot& robot) {
  using namespace std::chrono_literals;
  robot.add<Numbers>("numbers");
  robot.add<Sums>("sums", {{"latest", "numbers.out"}, {"all", "numbers.out"}});
  robot.add<Pictures>("pictures");
  robot.add<Looks>("looks", {{"image", "pictures.image"}});
  robot.periodic("fast", 3, 1ms, {"numbers"});
  robot.periodic("slow", 2, 7ms, {"sums"});
  robot.periodic("view", 1, 10ms, {"pictures", "looks"});
  robot.spec.topics.push_back({"pictures.image", Pictures::kBytes, Pictures::kBytes, 5});
  robot.spec.robot = "recorded";
  robot.spec.seed = 7;
}

/// Its runs in virtual time; the files are in `disks`.
class RecordedRobot : public ::testing::Test {
 protected:
  RecordedRobot() {
    make_robot(robot);
    robot.configure_options.recorded = true;
  }

  std::unique_ptr<RunRecorder> open(RunRecorder::Pace pace, const RecorderOptions& options = {}) {
    auto opened = RunRecorder::open(
        robot.build(), pace,
        [this](unsigned part) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
          if (on_open) on_open();
          while (disks.size() <= part) disks.push_back(std::make_unique<Disk>());
          return std::unique_ptr<hal::OutputFile>(new MemoryOutput(*disks[part]));
        },
        about, options);
    EXPECT_TRUE(opened) << opened.error().where;
    return std::move(*opened);
  }
  /// Everything but finish().
  void run(RunRecorder& recorder, rt::Duration duration) {
    robot.grants.end = rt::Time{duration.count()};
    rt::DiscreteOptions discrete;
    discrete.hash_topics = true;
    discrete.observer = &recorder.observer();
    executor = std::make_unique<rt::DiscreteExecutor>(robot.graph(), robot.clock, robot.grants, discrete);
    EXPECT_TRUE(executor->run());
  }
  /// `room`: of the first disk, until the flight ends.
  std::unique_ptr<RunRecorder> fly(rt::Duration duration, const RecorderOptions& options = {},
                                   std::uint64_t room = ~std::uint64_t{0}) {
    auto recorder = open(RunRecorder::Pace::waited_for, options);
    disks[0]->room = room;
    run(*recorder, duration);
    disks[0]->room = ~std::uint64_t{0};  // there is room again
    EXPECT_TRUE(recorder->finish());
    return recorder;
  }

  static std::unique_ptr<Reader> read(const Bytes& bytes) {
    FileProblem why;
    auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why);
    EXPECT_TRUE(reader) << to_string(why);
    return reader;
  }
  std::unique_ptr<Reader> read(unsigned part = 0) { return read(disks.at(part)->bytes); }

  /// The first file rewritten, with the metadata `last` at its end.
  template <class F>
  Bytes rewritten(
      F&& change, const std::optional<Metadata>& last = {},
      const std::function<void(Schema&)>& renew = [](Schema&) {}) {
    const auto from = read();
    Disk to;
    auto writer = Writer::open(std::make_unique<MemoryOutput>(to), {});
    EXPECT_TRUE(rewrite(*from, **writer, change, renew));
    if (last) {
      EXPECT_TRUE((*writer)->add_metadata(*last));
    }
    EXPECT_TRUE((*writer)->finish());
    return to.bytes;
  }

  rt::Robot robot;
  RunDescription about;
  std::vector<std::unique_ptr<Disk>> disks;
  std::function<void()> on_open{};  // a stall
  std::unique_ptr<rt::DiscreteExecutor> executor;
};

}  // namespace sinew::record
