#include "record/queued_file.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "hal/platform.hpp"
#include "memory_file.hpp"
#include "record/check.hpp"
#include "record/writer.hpp"

namespace sinew::record::queued_file_test {
namespace {

using namespace std::chrono_literals;

class QueuedFileTest : public ::testing::Test {
 protected:
  std::unique_ptr<hal::OutputFile> open(std::uint64_t most_bytes = 1000) {
    auto file = QueuedFile::open(std::make_unique<MemoryOutput>(disk), most_bytes, hal::system_os());
    EXPECT_TRUE(file);
    return std::move(*file);
  }
  static hal::Status append(hal::OutputFile& file, std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    return file.append({&bytes, 1});
  }
  std::string text() const { return {reinterpret_cast<const char*>(disk.bytes.data()), disk.bytes.size()}; }
  void stall() {
    disk.on_append = [this] {
      while (stalled) std::this_thread::sleep_for(1ms);
    };
  }

  Disk disk;
  std::atomic<bool> stalled{true};
};

TEST_F(QueuedFileTest, WhatWasAppendedDuringAStallIsInTheFileInItsOrder) {
  stall();
  const auto file = open();
  for (const char* part : {"one ", "two ", "three"}) EXPECT_TRUE(append(*file, part));
  EXPECT_TRUE(file->sync()) << "nothing waits for the disk";
  stalled = false;
  EXPECT_TRUE(file->settle());
  EXPECT_EQ(text(), "one two three");
  EXPECT_EQ(disk.synced, disk.bytes.size());
}

TEST_F(QueuedFileTest, WhatWaitsIsNotFreeOnTheDisk) {
  stall();
  disk.free = 100;
  const auto file = open();
  EXPECT_EQ(*file->free_bytes(), 100u);
  EXPECT_TRUE(append(*file, "0123456789"));
  EXPECT_EQ(*file->free_bytes(), 90u);
  stalled = false;
}

TEST_F(QueuedFileTest, MoreThanMayWaitWaitsForTheDisk) {
  stall();
  const auto file = open(8);
  EXPECT_TRUE(append(*file, "01234567"));
  std::atomic<bool> taken{false};
  std::thread late([&] {
    EXPECT_TRUE(append(*file, "89"));
    taken = true;
  });
  std::this_thread::sleep_for(20ms);
  EXPECT_FALSE(taken);
  stalled = false;
  late.join();
  EXPECT_TRUE(file->settle());
  EXPECT_EQ(text(), "0123456789");
}

TEST_F(QueuedFileTest, AFullDiskRefusesUntilThereIsRoomAndLeavesNoPartOfABlock) {
  disk.room = 5;
  const auto file = open();
  EXPECT_TRUE(append(*file, "0123"));
  EXPECT_TRUE(file->settle());
  EXPECT_TRUE(append(*file, "4567")) << "taken: the disk has not said no yet";
  const auto refused = file->settle();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, ENOSPC);
  EXPECT_EQ(text(), "0123");
  EXPECT_FALSE(append(*file, "89"));
  disk.room = 100;
  EXPECT_TRUE(file->settle());
  EXPECT_TRUE(append(*file, "89"));
  EXPECT_TRUE(file->settle());
  EXPECT_EQ(text(), "0123456789");
}

TEST_F(QueuedFileTest, CutTakesAwayWhatWaitsAndWhatIsWritten) {
  const auto file = open();
  EXPECT_TRUE(append(*file, "0123"));
  EXPECT_TRUE(file->settle());
  EXPECT_TRUE(append(*file, "4567"));
  EXPECT_TRUE(file->cut(6));
  EXPECT_TRUE(file->settle());
  EXPECT_EQ(text(), "012345");
  EXPECT_TRUE(file->cut(2));
  EXPECT_TRUE(append(*file, "89"));
  EXPECT_TRUE(file->settle());
  EXPECT_EQ(text(), "0189");
}

TEST_F(QueuedFileTest, AFileIsNotFinishedWhileItsEndIsNotOnTheDisk) {
  auto writer = Writer::open(open(1 << 20), {});
  ASSERT_TRUE(writer);
  disk.room = 10;
  EXPECT_FALSE((*writer)->finish());
  EXPECT_TRUE((*writer)->is_open());
  disk.room = 1 << 20;
  // The file tries a refused block again every 100 ms, and takes nothing before.
  hal::Status finished = (*writer)->finish();
  for (int again = 0; !finished && again < 100; ++again) {
    std::this_thread::sleep_for(20ms);
    finished = (*writer)->finish();
  }
  EXPECT_TRUE(finished);
  writer->reset();
  MemoryInput again(disk.bytes);
  EXPECT_TRUE(check(again).empty());
}

}  // namespace
}  // namespace sinew::record::queued_file_test
