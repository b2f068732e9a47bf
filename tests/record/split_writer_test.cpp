#include "record/split_writer.hpp"

#include <deque>

#include "samples.hpp"

namespace sinew::record {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

/// A folder of files in memory that a test can make fail.
struct Folder {
  std::deque<Disk> disks;
  bool refuses = false;
  std::uint64_t room = ~std::uint64_t{0};  // of each new file
  SplitWriter::OpenPart opener() {
    return [this](unsigned part) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
      if (refuses) return hal::Error{hal::Errc::denied, "folder"};
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
    Problem why;
    EXPECT_EQ(reader->metadata().size(), 1u);
    EXPECT_TRUE(reader->read(reader->metadata().at(0), metadata, why));
    EXPECT_EQ(metadata.values.at("number"), std::to_string(i));
    for (const Sample& s : all(*reader, {}).samples) list.push_back(s.stamps.log_time);
  }
  return list;
}

std::vector<std::uint64_t> up_to(std::uint64_t count) {
  std::vector<std::uint64_t> list(count);
  std::iota(list.begin(), list.end(), std::uint64_t{1});
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

TEST(SplitWriter, GoesOnInItsFileWhileThereIsNoOther) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {.chunk_bytes = 2048}, .file_bytes = 10'000});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  folder.refuses = true;
  for (std::uint64_t t = 1; t <= 300; ++t) ASSERT_TRUE(write(*out, t));
  EXPECT_EQ(folder.disks.size(), 1u);
  EXPECT_GT(out->failed_splits(), 0u);
  EXPECT_LT(out->failed_splits(), 30u);  // tried once a chunk
  folder.refuses = false;
  for (std::uint64_t t = 301; t <= 400; ++t) ASSERT_TRUE(write(*out, t));
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), up_to(400));
  EXPECT_GT(folder.disks.size(), 1u);
}

TEST(SplitWriter, AFileThatCannotBeBegunIsBegunAgainLater) {
  Folder folder;
  auto out = SplitWriter::open(folder.opener(), begin, {.writer = {}, .file_duration = 100ns});
  ASSERT_TRUE(out->writer().add_channel("/a", "cdr", 0));
  std::vector<std::uint64_t> taken;
  for (std::uint64_t t = 1; t <= 300; ++t) {
    folder.room = t > 90 && t < 150 ? 10 : ~std::uint64_t{0};
    if (write(*out, t)) taken.push_back(t);
  }
  ASSERT_TRUE(out->finish());
  EXPECT_EQ(times(folder), taken);
  EXPECT_EQ(taken.size(), 300u - 49u);  // from 101 to 149 there was no file to write to
  EXPECT_EQ(out->finish().error().code, hal::Errc::closed);
  EXPECT_EQ(write(*out, 1).error().code, hal::Errc::closed);
}

}  // namespace
}  // namespace sinew::record
