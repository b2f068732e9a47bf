#include "record/later_files.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "hal/platform.hpp"
#include "memory_file.hpp"

namespace sinew::record::later_files_test {
namespace {

using namespace std::chrono_literals;

class LaterFilesTest : public ::testing::Test {
 protected:
  LaterFilesTest() {
    files.emplace(
        [this](unsigned part) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
          ++made;
          while (part > 0 && stalled) std::this_thread::sleep_for(1ms);
          if (refuses.exchange(false)) return hal::Error{hal::Errc::denied, "folder"};
          return std::unique_ptr<hal::OutputFile>(new MemoryOutput(disks[part]));
        },
        hal::system_os());
  }
  ~LaterFilesTest() override { stalled = false; }
  /// Asks until there is a file or an error.
  hal::Result<std::unique_ptr<hal::OutputFile>> wait_for(unsigned part) {
    while (true) {
      auto file = files->open(part);
      if (!file || *file) return file;
      std::this_thread::sleep_for(1ms);
    }
  }

  std::array<Disk, 3> disks;
  std::atomic<bool> stalled{false}, refuses{false};
  std::atomic<int> made{0};
  std::optional<LaterFiles> files;
};

TEST_F(LaterFilesTest, TheFirstFileIsThereAtOnce) {
  const auto file = files->open(0);
  ASSERT_TRUE(file);
  EXPECT_TRUE(*file);
}

TEST_F(LaterFilesTest, NobodyWaitsForALaterOne) {
  stalled = true;
  for (int again = 0; again < 5; ++again) {
    const auto file = files->open(1);
    ASSERT_TRUE(file);
    EXPECT_FALSE(*file);
  }
  stalled = false;
  EXPECT_TRUE(wait_for(1));
  EXPECT_TRUE(wait_for(2));
  EXPECT_EQ(made, 2) << "each once, however often it was asked for";
}

TEST_F(LaterFilesTest, AFailureIsToldOnceAndTheFileThenMadeAgain) {
  refuses = true;
  EXPECT_EQ(wait_for(1).error().code, hal::Errc::denied);
  EXPECT_TRUE(wait_for(1));
  EXPECT_EQ(made, 2);
}

TEST_F(LaterFilesTest, AFileThatNobodyTookIsRemoved) {
  EXPECT_TRUE(wait_for(1));
  ASSERT_TRUE(files->open(2));
  files.reset();
  EXPECT_FALSE(disks[1].removed);
  EXPECT_TRUE(disks[2].removed);
}

}  // namespace
}  // namespace sinew::record::later_files_test
