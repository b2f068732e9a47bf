#include "record/split_writer.hpp"

#include <deque>

#include "samples.hpp"

namespace sinew::record::split_writer_test {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

constexpr std::uint64_t kMs = 1'000'000;

/// A folder of files in memory that a test can make fail.
struct Folder {
  std::deque<Disk> disks;
  bool refuses = false, not_yet = false;
  int asked = 0;
  std::uint64_t room = ~std::uint64_t{0};  // of each new file, and of the last one
  void set_room(std::uint64_t bytes) {
    room = bytes;
    if (disks.size() > 1) disks.back().room = bytes;
  }
  SplitWriter::OpenPart opener() {
    return [this](unsigned part) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
      ++asked;
      if (refuses) return hal::Error{hal::Errc::denied, "folder"};
      if (not_yet) return std::unique_ptr<hal::OutputFile>();
      if (part == disks.size()) disks.emplace_back();
      disks[part].room = room;
      return std::unique_ptr<hal::OutputFile>(new MemoryOutput(disks[part]));
    };
  }
};

hal::Status begin(Writer& writer, unsigned part) {
  return writer.add_metadata({"part", {{"number", std::to_string(part)}}});
}

hal::Status write(SplitWriter& out, std::uint64_t time, std::size_t size = 100) {
  const std::string data = some_data(static_cast<std::uint32_t>(time), size);
  return out.write(1, {static_cast<std::uint32_t>(time), time, time}, as_bytes(data));
}

/// Every file whole by itself, with its beginning; the times of all messages, as they come.
std::vector<std::uint64_t> times(const Folder& folder) {
  std::vector<std::uint64_t> list;
  for (std::size_t i = 0; i < folder.disks.size(); ++i) {
    EXPECT_THAT(check_bytes(folder.disks[i].bytes), IsEmpty()) << "file " << i;
    auto reader = open(folder.disks[i].bytes);
    Metadata metadata;
    FileProblem why;
    EXPECT_EQ(reader->metadata().size(), 1u);
    EXPECT_TRUE(reader->read(reader->metadata().at(0), metadata, why));
    EXPECT_EQ(metadata.values.at("number"), std::to_string(i));
    for (const Sample& s : all(*reader, {}).samples) list.push_back(s.stamps.log_time);
  }
  return list;
}

std::vector<std::uint64_t> up_to(std::uint64_t count, std::uint64_t step = 1) {
  std::vector<std::uint64_t> list;
  for (std::uint64_t t = 1; t <= count; ++t) list.push_back(t * step);
  return list;
}

TEST(SplitWriter, StartsAnotherFileWhereOneWouldOutgrowItsBytes) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {.chunk_bytes = 2048}, .file_bytes = 10'000});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 1; t <= 500; ++t) ASSERT_TRUE(write(*out, t));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(500));
  EXPECT_GT(folder.disks.size(), 3u);
  for (const Disk& disk : folder.disks) EXPECT_LT(disk.bytes.size(), 12'000u);
}

TEST(SplitWriter, StartsAnotherFileWhenOneIsOldEnough) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 1; t <= 450; ++t) ASSERT_TRUE(write(*out, t));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(450));
  EXPECT_EQ(folder.disks.size(), 5u);
}

TEST(SplitWriter, AFileHasAtLeastAsMuchToSayAsItBeginsWith) {
  Folder folder;
  const auto large = [](Writer& writer, unsigned part) {
    if (auto done = writer.attach({1, 1, "robot.toml", "", std::string(5000, 'x')}); !done) return done;
    return begin(writer, part);
  };
  auto out = SplitWriter::open(folder.opener(), large, {.writer = {}, .file_bytes = 3000});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 1; t <= 200; ++t) ASSERT_TRUE(write(*out, t));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(200));
  EXPECT_EQ(folder.disks.size(), 6u);  // 26 kB of messages in pieces of 5
}

TEST(SplitWriter, AMessageAtTimeZeroIsOneToo) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 0; t < 200; ++t) ASSERT_TRUE(write(*out, t));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(folder.disks.size(), 2u);
}

TEST(SplitWriter, GoesOnInItsFileWhileThereIsNoOther) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {.chunk_bytes = 2048}, .file_bytes = 10'000});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.refuses = true;
  for (std::uint64_t t = 1; t <= 300; ++t) ASSERT_TRUE(write(*out, t * 10 * kMs));
  EXPECT_EQ(folder.disks.size(), 1u);
  EXPECT_EQ(static_cast<std::uint64_t>(folder.asked - 1), out->failed_splits());
  EXPECT_GT(out->failed_splits(), 10u);
  EXPECT_LT(out->failed_splits(), 30u);  // tried ten times a second
  folder.refuses = false;
  for (std::uint64_t t = 301; t <= 400; ++t) ASSERT_TRUE(write(*out, t * 10 * kMs));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(400, 10 * kMs));
  EXPECT_GT(folder.disks.size(), 1u);
}

TEST(SplitWriter, GoesOnInItsFileUntilTheNextOneIsThere) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 1s});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.not_yet = true;
  for (std::uint64_t t = 1; t <= 200; ++t) ASSERT_TRUE(write(*out, t * 10 * kMs));
  EXPECT_EQ(out->part(), 0u);
  EXPECT_EQ(folder.asked, 1 + 100) << "with every message from 1.01 s on";
  EXPECT_EQ(out->failed_splits(), 0u);
  folder.not_yet = false;
  ASSERT_TRUE(write(*out, 2010 * kMs));
  EXPECT_EQ(out->part(), 1u);
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(201, 10 * kMs));
}

TEST(SplitWriter, AFileThatIsNotThereAfterAFailureIsNoOtherFailure) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 1; t <= 100; ++t) ASSERT_TRUE(write(*out, t));
  folder.set_room(10);
  EXPECT_EQ(write(*out, 101).error().detail, ENOSPC);
  folder.set_room(~std::uint64_t{0});
  folder.not_yet = true;
  EXPECT_EQ(write(*out, 200 * kMs).error().detail, ENOSPC) << "why there is no file";
  EXPECT_EQ(out->failed_splits(), 1u);
  folder.not_yet = false;
  EXPECT_TRUE(write(*out, 300 * kMs));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder).size(), 101u);
}

TEST(SplitWriter, DoesNotWaitUntilTheFileBeforeHasSettled) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.disks[0].stalls = true;
  for (std::uint64_t t = 1; t <= 350; ++t) ASSERT_TRUE(write(*out, t));
  EXPECT_EQ(out->part(), 1u) << "no third file while two are not on the disk";
  EXPECT_EQ(folder.disks[0].waits, 0);
  folder.disks[0].stalls = false;
  folder.disks[1].stalls = true;
  ASSERT_TRUE(write(*out, 351));
  EXPECT_EQ(out->part(), 2u);
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(folder.disks[1].waits, 1) << "a recording is complete when all of its files are";
  EXPECT_EQ(times(folder), up_to(351));
}

TEST(SplitWriter, IsNotFinishedWhileTheEndOfTheFileBeforeIsRefused) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.disks[0].stalls = folder.disks[0].settle_fails = true;
  for (std::uint64_t t = 1; t <= 150; ++t) ASSERT_TRUE(write(*out, t));
  EXPECT_EQ(out->finish().error().detail, ENOSPC);
  folder.disks[0].settle_fails = false;
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(150));
}

/// The next file has no more room than this from 0.9 to 1.5 s.
void run_out_of_room(std::uint64_t room) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 1s});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  std::vector<std::uint64_t> taken;
  for (std::uint64_t t = 1; t <= 300; ++t) {
    folder.set_room(t > 90 && t < 150 ? room : ~std::uint64_t{0});
    if (auto done = write(*out, t * 10 * kMs); done)
      taken.push_back(t * 10 * kMs);
    else
      ASSERT_EQ(done.error().detail, ENOSPC);  // why, and not only that there is no file
  }
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), taken);
  EXPECT_EQ(taken.size(), 300u - 50u);  // from 1.01 s to 1.5 s there was no file to write to
  EXPECT_LT(folder.asked, 12);
  EXPECT_EQ(out->finish().error().code, hal::Errc::closed);
  EXPECT_EQ(write(*out, 1).error().code, hal::Errc::closed);
}

TEST(SplitWriter, AFileThatCannotBeBegunIsBegunAgainLater) { run_out_of_room(10); }

TEST(SplitWriter, WhatAFileBeginsWithIsTriedAgainUntilItIsThere) { run_out_of_room(60); }

TEST(SplitWriter, EndsWellWhenTheNextFileNeverCameToBe) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  for (std::uint64_t t = 1; t <= 100; ++t) ASSERT_TRUE(write(*out, t));
  folder.set_room(10);
  EXPECT_FALSE(write(*out, 101));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(out->part(), 0u);
  EXPECT_THAT(folder.disks.back().bytes, IsEmpty());
  folder.disks.pop_back();
  EXPECT_EQ(times(folder), up_to(100));
}

TEST(SplitWriter, DoesNotSplitIntoTheFreeFloor) {
  Folder folder;
  auto out =
      SplitWriter::open(folder.opener(), begin, {.writer = {.free_floor_bytes = 1'000'000}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.disks[0].free = 1'000'000;
  for (std::uint64_t t = 1; t <= 200; ++t) ASSERT_TRUE(write(*out, t));  // in memory
  EXPECT_EQ(folder.asked, 1);
  EXPECT_EQ(out->failed_splits(), 1u);
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(200));
}

}  // namespace
}  // namespace sinew::record::split_writer_test
