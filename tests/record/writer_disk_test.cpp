// The writer when its disk is full, down to its free floor, or broken.
#include "record/writer.hpp"

#include "samples.hpp"

namespace sinew::record::writer_disk_test {
namespace {

using testing::IsEmpty;

constexpr std::uint64_t kMs = 1'000'000;

TEST(WriterOnABadDisk, AFullDiskCostsMessagesAndNeverTheFile) {
  Disk disk;
  SampleWriter out(disk, {.compression = Compression::none, .chunk_bytes = 1500});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(out.write("/a", i * kMs, 100));
  disk.room = disk.bytes.size() + 700;  // a part of the next chunk
  int refused = 0;
  for (std::uint64_t i = 50; i < 1000; ++i) {
    const auto done = out.write("/a", i * kMs, 100);
    refused += done ? 0 : 1;
    if (!done) {
      ASSERT_EQ(done.error().code, hal::Errc::io);
      ASSERT_EQ(done.error().detail, ENOSPC);
    }
    ASSERT_EQ(disk.bytes.size(), out.writer().counters().file_bytes);  // nothing half written
  }
  EXPECT_GT(refused, 900);
  disk.room = ~std::uint64_t{0};  // there is room again
  for (std::uint64_t i = 1100; i < 1200; ++i) ASSERT_TRUE(out.write("/a", i * kMs, 100));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
  EXPECT_EQ(all(*open(disk.bytes), {}).samples, out.samples());  // all that were taken, and no other
}

TEST(WriterOnABadDisk, OneThatSaidNoIsLeftAloneForAWhile) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 1500});
  out.add_channel("/a");
  out.add_channel("/image", Packing::plain);
  while (out.writer().counters().chunks == 0) ASSERT_TRUE(out.write("/a", kMs, 100));
  disk.room = disk.bytes.size();
  const int before = disk.appends;
  for (std::uint64_t ms = 2; ms < 1000; ++ms) {
    static_cast<void>(out.write("/a", ms * kMs, 100));
    static_cast<void>(out.write("/image", ms * kMs, 100'000));
    static_cast<void>(out.writer().tick(ms * kMs));
  }
  EXPECT_EQ(static_cast<std::uint64_t>(disk.appends - before), out.writer().counters().failed_writes);
  EXPECT_GE(disk.appends - before, 9);  // 2, 102, ... 902 ms
  EXPECT_LE(disk.appends - before, 10);
}

TEST(WriterOnABadDisk, ALargeMessageThatDoesNotFitIsAsIfItHadNotBeen) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 1 << 20});
  out.add_channel("/image", Packing::plain);
  ASSERT_TRUE(out.write("/image", 5, 90'000));
  ASSERT_TRUE(out.write("/image", 7, 1000));  // waits in memory
  disk.room = disk.bytes.size() + 50'000;
  EXPECT_FALSE(out.write("/image", 1, 90'000));
  disk.room = ~std::uint64_t{0};
  ASSERT_TRUE(out.write("/image", 200 * kMs, 90'000));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
  EXPECT_EQ(all(*open(disk.bytes), {}).samples, out.samples());
}

TEST(WriterOnABadDisk, AnUnfinishableFileIsReadableAndCanBeFinishedLater) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 1500});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(out.write("/a", i, 100));
  ASSERT_TRUE(out.writer().flush());
  disk.room = disk.bytes.size() + 20;
  EXPECT_FALSE(out.writer().finish());
  EXPECT_EQ(all(*open(disk.bytes), {}).samples, out.samples());
  disk.room = ~std::uint64_t{0};
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
  EXPECT_EQ(out.write("/a", 1, 1).error().code, hal::Errc::closed);
}

TEST(WriterOnABadDisk, WhatCannotBeTakenOutOfTheFileEndsIt) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 1500});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i < 30; ++i) ASSERT_TRUE(out.write("/a", i, 100));
  const auto before = out.writer().counters().messages;
  disk.room = disk.bytes.size() + 100, disk.cut_fails = true;
  EXPECT_FALSE(out.writer().flush());
  disk.room = ~std::uint64_t{0};
  EXPECT_EQ(out.writer().flush().error().code, hal::Errc::closed);
  EXPECT_EQ(all(*open(disk.bytes), {}).samples.size(), before);
}

/// A writer whose disk is down to its free floor, with messages in memory.
class AtTheFloor : public testing::Test {
 protected:
  AtTheFloor() : out_(disk_, {.chunk_bytes = 1500, .free_floor_bytes = 1'000'000 - 900}) {
    disk_.free = 1'000'000;
    out_.add_channel("/a");
    out_.add_channel("/image", Packing::plain);
    size_ = disk_.bytes.size();
    for (std::uint64_t i = 0; i < 50 && refusal_; ++i) refusal_ = out_.write("/a", i, 200);
  }
  Disk disk_;
  SampleWriter out_;
  std::size_t size_ = 0;
  hal::Status refusal_;
};

TEST_F(AtTheFloor, NoChunkIsWritten) {
  ASSERT_FALSE(refusal_);
  EXPECT_EQ(refusal_.error().detail, ENOSPC);
  EXPECT_STREQ(refusal_.error().where, "record: the disk is full up to its free floor");
  EXPECT_FALSE(out_.writer().room());
  EXPECT_FALSE(out_.writer().flush());
  EXPECT_FALSE(out_.writer().tick(1500 * kMs));
  EXPECT_FALSE(out_.writer().attach({1, 1, "a", "text/plain", "x"}));
  EXPECT_FALSE(out_.write("/image", 3000 * kMs, 100'000));
  EXPECT_EQ(disk_.bytes.size(), size_);
}

TEST_F(AtTheFloor, RecordingGoesOnWhenThereIsRoomAgain) {
  disk_.free = 2'000'000;
  ASSERT_TRUE(out_.write("/a", 200 * kMs, 200));
  ASSERT_TRUE(out_.writer().finish());
  EXPECT_EQ(all(*open(disk_.bytes), {}).samples, out_.samples());
}

TEST_F(AtTheFloor, TheEndOfTheFileAndWhatItSaysHaveRoomInTheFloor) {
  ASSERT_TRUE(out_.writer().add_metadata({"verdict", {{"imu", "gap at 3 s"}}}));
  ASSERT_TRUE(out_.writer().finish());
  EXPECT_THAT(check_bytes(disk_.bytes), IsEmpty());
  auto reader = open(disk_.bytes);
  EXPECT_EQ(reader->metadata().at(0).name, "verdict");
  EXPECT_EQ(all(*reader, {}).samples, out_.samples());
}

TEST(WriterOnABadDisk, AFailedSyncIsCountedAndCostsNoMessage) {
  Disk disk;
  disk.sync_fails = true;
  SampleWriter out(disk, {.chunk_bytes = 1500});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(out.write("/a", i, 100));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_EQ(out.writer().counters().failed_syncs, static_cast<std::uint64_t>(disk.syncs));
  EXPECT_EQ(all(*open(disk.bytes), {}).samples, out.samples());
}

TEST(WriterOnABadDisk, WhatAFileShallBeginWithIsThereAsAWholeOrNotAtAll) {
  Disk disk;
  SampleWriter out(disk, {});
  out.add_channel("/a");
  const auto beginning = [](Writer& writer) {
    if (auto done = writer.add_metadata({"robot", {{"name", "quad"}}}); !done) return done;
    return writer.attach({1, 1, "robot.toml", "application/toml", std::string(500, 'x')});
  };
  disk.room = disk.bytes.size() + 200;  // enough for the metadata
  EXPECT_EQ(out.writer().begin_with(beginning).error().detail, ENOSPC);
  disk.room = ~std::uint64_t{0};
  ASSERT_TRUE(out.writer().begin_with(beginning));
  ASSERT_TRUE(out.write("/a", 1, 10));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
  EXPECT_EQ(open(disk.bytes)->metadata().size(), 1u);
  EXPECT_EQ(open(disk.bytes)->attachments().size(), 1u);
}

TEST(WriterOnABadDisk, AttachmentsAndMetadataAreSyncedWithoutAnyMessage) {
  Disk disk;
  SampleWriter out(disk, {});
  ASSERT_TRUE(out.writer().attach({1, 1, "a", "text/plain", "x"}));
  ASSERT_TRUE(out.writer().tick(2000 * kMs));
  EXPECT_EQ(disk.synced, disk.bytes.size());
  ASSERT_TRUE(out.writer().add_metadata({"m", {}}));
  ASSERT_TRUE(out.writer().tick(4000 * kMs));
  EXPECT_EQ(disk.synced, disk.bytes.size());
}

TEST(WriterOnABadDisk, AFileThatCannotBeEndedGoesOnAndTheOtherOneIsRemoved) {
  Disk first, second;
  SampleWriter out(first, {});
  out.add_channel("/a");
  ASSERT_TRUE(out.write("/a", 1, 10));
  first.room = first.bytes.size();
  std::unique_ptr<hal::OutputFile> former;
  EXPECT_EQ(out.writer().continue_in(std::make_unique<MemoryOutput>(second), former).error().detail, ENOSPC);
  EXPECT_TRUE(second.removed);
  EXPECT_FALSE(former);
  first.room = ~std::uint64_t{0};
  ASSERT_TRUE(out.write("/a", 2, 10));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(first.bytes), IsEmpty());
  EXPECT_EQ(all(*open(first.bytes), {}).samples, out.samples());
}

TEST(WriterOnABadDisk, AFileThatCannotBeBegunIsNotWrittenTo) {
  Disk first, full, second;
  full.room = 10;
  SampleWriter out(first, {});
  out.add_channel("/a");
  ASSERT_TRUE(out.write("/a", 1, 10));
  std::unique_ptr<hal::OutputFile> former, none;
  EXPECT_FALSE(out.writer().continue_in(std::make_unique<MemoryOutput>(full), former));
  EXPECT_TRUE(former) << "the first one has its end";
  EXPECT_TRUE(full.removed) << "its name is free for the next attempt";
  EXPECT_EQ(out.write("/a", 2, 10).error().code, hal::Errc::closed);
  EXPECT_THAT(full.bytes, IsEmpty());
  ASSERT_TRUE(out.writer().continue_in(std::make_unique<MemoryOutput>(second), none));
  EXPECT_FALSE(none);
  ASSERT_TRUE(out.write("/a", 3, 10));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(first.bytes), IsEmpty());
  EXPECT_EQ(all(*open(second.bytes), {}).samples.size(), 1u);
}

}  // namespace
}  // namespace sinew::record::writer_disk_test
