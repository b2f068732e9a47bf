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
    return open(disk, std::make_shared<QueueMemory>(most_bytes));
  }
  static std::unique_ptr<hal::OutputFile> open(Disk& on, std::shared_ptr<QueueMemory> memory) {
    auto file = QueuedFile::open(std::make_unique<MemoryOutput>(on), std::move(memory), hal::system_os());
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

TEST_F(QueuedFileTest, HasSettledWhenAllIsWrittenAndSynced) {
  stall();
  const auto file = open();
  EXPECT_TRUE(file->settled()) << "nothing was appended";
  EXPECT_TRUE(append(*file, "0123"));
  EXPECT_FALSE(file->settled());
  std::atomic<bool> syncs{false}, stalled_too{true};
  disk.on_sync = [&] {
    for (syncs = true; stalled_too;) std::this_thread::sleep_for(1ms);
  };
  EXPECT_TRUE(file->sync());
  stalled = false;
  while (!syncs) std::this_thread::sleep_for(1ms);
  EXPECT_FALSE(file->settled());
  stalled_too = false;
  while (!file->settled()) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(text(), "0123");
  EXPECT_EQ(disk.synced, 4u);
}

TEST_F(QueuedFileTest, FilesOfOneMemoryHoldItsBoundTogether) {
  stall();
  Disk other;
  const auto memory = std::make_shared<QueueMemory>(8);
  const auto file = open(disk, memory), second = open(other, memory);
  other.on_append = disk.on_append;
  EXPECT_TRUE(append(*file, "01234567"));
  EXPECT_TRUE(append(*second, "a")) << "each may have something in memory";
  std::atomic<bool> taken{false};
  std::thread late([&] {
    EXPECT_TRUE(append(*second, "b"));
    taken = true;
  });
  std::this_thread::sleep_for(20ms);
  EXPECT_FALSE(taken);
  stalled = false;
  late.join();
  EXPECT_TRUE(file->settle());
  EXPECT_TRUE(second->settle());
  EXPECT_EQ(other.bytes.size(), 2u);
}

TEST_F(QueuedFileTest, WhatWaitsInAnotherFileOfTheDiskIsNotFreeEither) {
  stall();
  Disk other;
  disk.free = other.free = 100;
  const auto memory = std::make_shared<QueueMemory>(1000);
  const auto file = open(disk, memory), second = open(other, memory);
  EXPECT_TRUE(append(*file, "0123456789"));
  EXPECT_EQ(*second->free_bytes(), 90u);
  stalled = false;
}

TEST_F(QueuedFileTest, AFileThatIsClosedGivesItsMemoryBack) {
  Disk other;
  disk.free = 100;
  const auto memory = std::make_shared<QueueMemory>(8);
  const auto file = open(disk, memory);
  {
    other.room = 0;
    const auto full = open(other, memory);
    EXPECT_TRUE(append(*full, "01234567"));
    EXPECT_FALSE(full->settle());
  }
  EXPECT_EQ(*file->free_bytes(), 100u) << "less while it takes memory";
}

TEST_F(QueuedFileTest, ARemovedFileTakesWhatWaitsAlong) {
  disk.room = 0;
  const auto file = open();
  EXPECT_TRUE(append(*file, "0123"));
  EXPECT_FALSE(file->settle());
  EXPECT_TRUE(file->remove());
  EXPECT_TRUE(disk.removed);
  EXPECT_TRUE(file->settled());
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
