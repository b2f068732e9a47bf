#include "apps/robot/write_stall.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/module_list.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/platform.hpp"
#include "source_dir.hpp"

namespace sinew::app::write_stall_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// A disk whose third sync takes long.
class StallingFile final : public hal::OutputFile {
 public:
  hal::Status append(hal::Parts parts) noexcept override {
    for (const auto& part : parts) bytes += part.size();
    return {};
  }
  hal::Status sync() noexcept override {
    if (++syncs == 3) os.sleep_until(os.now() + 300ms);
    return {};
  }
  hal::Status cut(std::uint64_t) noexcept override { return {}; }
  hal::Result<std::uint64_t> free_bytes() noexcept override { return ~std::uint64_t{0}; }
  hal::Os& os = hal::system_os();
  std::uint64_t bytes = 0;
  int syncs = 0;
};

TEST(WriteStallTest, TheWorstStallIsFoundAndWhatComesDueMeanwhileIsWritten) {
  StallingFile file;
  const auto stall = measure_write_stall(file, file.os, 10e6, 1s);
  ASSERT_TRUE(stall);
  EXPECT_GE(stall->worst, 300ms);
  EXPECT_EQ(stall->bytes, file.bytes);
  EXPECT_GT(file.syncs, 3);
}

TEST(WriteStallTest, SaysWhatBufferTheStallNeeds) {
  RecordOptions record;
  const auto short_one = write_stall_check({.worst = 100ms, .length = 10s, .bytes = 80'000'000}, 8e6, record);
  EXPECT_EQ(short_one.state, hal::CheckState::ok);
  EXPECT_THAT(short_one.seen, HasSubstr("runs: worst write stall 0.100 s in 10 s"));
  EXPECT_THAT(short_one.seen, HasSubstr("needs a buffer of 7 MB, record.buffer_mb is 32"));
  const auto long_one = write_stall_check({.worst = 4s, .length = 10s, .bytes = 80'000'000}, 8e6, record);
  EXPECT_EQ(long_one.state, hal::CheckState::warning);
  EXPECT_THAT(long_one.advice, HasSubstr("buffer_mb = 53"));
  const auto slow = write_stall_check({.worst = 1s, .length = 10s, .bytes = 20'000'000}, 8e6, record);
  EXPECT_EQ(slow.state, hal::CheckState::problem);
  EXPECT_THAT(slow.advice, HasSubstr("too slow"));
}

TEST(WriteStallTest, TheDefaultBufferHoldsTwoAndAHalfSecondsOfTheQuad) {
  const LoadedRobot loaded = load_robot(sinew::test::source_dir() + "/robots/quad/quad.toml");
  rt::Graph graph(loaded.robot.graph, all_modules());
  ASSERT_TRUE(graph.check().empty());
  const double rate = recorded_bytes_per_s(graph, loaded.robot.record);
  EXPECT_GT(rate, 5.5e6) << "pixels and all messages";
  const auto check = write_stall_check({.worst = 2500ms, .length = 10s, .bytes = static_cast<std::uint64_t>(rate * 10)},
                                       rate, loaded.robot.record);
  EXPECT_EQ(check.state, hal::CheckState::ok) << check.seen;
}

TEST(WriteStallTest, NothingStaysInTheFolderAndOneThatCannotBeWrittenIsNamed) {
  RecordOptions record;
  const auto under = std::filesystem::path(::testing::TempDir()) / "write_stall_test";
  record.folder = (under / "runs").string();
  record.free_floor_mb = 0;
  EXPECT_NE(check_write_stall(record, 1e6, 0.1).state, hal::CheckState::unknown);
  EXPECT_FALSE(std::filesystem::exists(record.folder));
  std::filesystem::remove_all(under);
  record.folder = "/proc/runs";
  const auto none = check_write_stall(record, 1e6, 0.1);
  EXPECT_EQ(none.state, hal::CheckState::problem);
  EXPECT_THAT(none.seen, HasSubstr("/proc/runs: "));
}

}  // namespace
}  // namespace sinew::app::write_stall_test
