// The writer's output and when it writes; writer_disk_test.cpp has its failures.
#include "record/writer.hpp"

#include <cstring>

#include "../rt/counting_new.hpp"
#include "samples.hpp"

namespace sinew::record::writer_test {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

constexpr std::uint64_t kMs = 1'000'000;

std::string hex(std::span<const std::byte> bytes) {
  std::string out;
  for (const std::byte b : bytes) {
    char text[4];
    std::snprintf(text, sizeof text, "%02x ", std::to_integer<unsigned>(b));
    out += text;
  }
  return out;
}

TEST(Writer, ItsFirstBytesAreThoseOfThePublishedFormat) {
  Disk disk;
  SampleWriter out(disk, {.profile = "p", .library = "lib", .compression = Compression::none});
  const auto schema = *out.writer().add_schema("S", "e", "d");
  const auto channel = *out.writer().add_channel("/t", "m", schema, {{"k", "v"}});
  ASSERT_TRUE(out.writer().write(channel, {.sequence = 7, .log_time = 0x11, .publish_time = 0x22}, as_bytes("xyz")));
  ASSERT_TRUE(out.writer().flush());
  // Written down by hand from the tables of the specification.
  const std::string wanted =
      "89 4d 43 41 50 30 0d 0a "                                         // magic
      "01 0c 00 00 00 00 00 00 00 01 00 00 00 70 03 00 00 00 6c 69 62 "  // header: profile, library
      "06 8a 00 00 00 00 00 00 00 "                                      // chunk
      "11 00 00 00 00 00 00 00 11 00 00 00 00 00 00 00 "                 // its start and end
      "62 00 00 00 00 00 00 00 ";                                        // uncompressed size; then the checksum
  const std::string after =
      "00 00 00 00 62 00 00 00 00 00 00 00 "  // compression "", size of the records
      "03 11 00 00 00 00 00 00 00 01 00 01 00 00 00 53 01 00 00 00 65 01 00 00 00 64 "  // schema
      "04 1d 00 00 00 00 00 00 00 01 00 01 00 02 00 00 00 2f 74 01 00 00 00 6d "        // channel
      "0a 00 00 00 01 00 00 00 6b 01 00 00 00 76 "                                      // its metadata
      "05 19 00 00 00 00 00 00 00 01 00 07 00 00 00 11 00 00 00 00 00 00 00 "           // message
      "22 00 00 00 00 00 00 00 78 79 7a "                                               // publish time, data
      "07 16 00 00 00 00 00 00 00 01 00 10 00 00 00 "                                   // message index
      "11 00 00 00 00 00 00 00 40 00 00 00 00 00 00 00 ";                               // log time, place in the chunk
  const std::string got = hex(disk.bytes);
  EXPECT_EQ(got.substr(0, wanted.size()), wanted);
  EXPECT_EQ(got.substr(wanted.size() + 4 * 3), after);
}

TEST(Writer, AChunkEndsBeforeItWouldOutgrowItsBytes) {
  Disk disk;
  SampleWriter out(disk, {.compression = Compression::none, .chunk_bytes = 2000});
  out.add_channel("/a");
  for (std::uint32_t i = 0; i < 100; ++i) ASSERT_TRUE(out.write("/a", i, 150 + i));
  ASSERT_TRUE(out.write("/a", 100, 5000));  // longer than a chunk: one of its own
  ASSERT_TRUE(out.writer().finish());
  auto reader = open(disk.bytes);
  int longer = 0;
  for (const ChunkIndex& chunk : reader->chunks()) longer += chunk.uncompressed_size > 2000 ? 1 : 0;
  EXPECT_EQ(longer, 1);
  EXPECT_GT(reader->chunks().size(), 10u);
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
}

TEST(Writer, AChunkIsNeverOlderThanItsDuration) {
  Disk disk;
  SampleWriter out(disk, {.chunk_duration = 100ms});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i <= 40; ++i) ASSERT_TRUE(out.write("/a", i * 10 * kMs, 20));
  EXPECT_EQ(out.writer().counters().chunks, 4u);
  EXPECT_EQ(out.writer().counters().messages, 40u);  // the last one waits in memory
  ASSERT_TRUE(out.writer().tick(499 * kMs));
  EXPECT_EQ(out.writer().counters().chunks, 4u);
  ASSERT_TRUE(out.writer().tick(500 * kMs));  // nobody wrote, the chunk is old all the same
  EXPECT_EQ(out.writer().counters().messages, 41u);
}

TEST(Writer, EveryChunkOfSmallMessagesIsSynced) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 2048});
  out.add_channel("/a");
  for (std::uint64_t i = 0; i < 100; ++i) ASSERT_TRUE(out.write("/a", i, 200));
  EXPECT_EQ(static_cast<std::uint64_t>(disk.syncs), out.writer().counters().chunks);
  EXPECT_EQ(disk.synced, disk.bytes.size());
}

TEST(Writer, ImagesAreSyncedOnceInAChunkDuration) {
  Disk disk;
  SampleWriter out(disk, {.chunk_duration = 1000ms});
  out.add_channel("/image", Packing::plain);
  for (std::uint64_t i = 0; i <= 60; ++i) ASSERT_TRUE(out.write("/image", i * 33 * kMs, 80'000));
  EXPECT_EQ(out.writer().counters().chunks, 61u);  // each written from where it lay
  EXPECT_EQ(disk.syncs, 1);
  ASSERT_TRUE(out.writer().tick(3100 * kMs));
  EXPECT_EQ(disk.syncs, 2);
  EXPECT_EQ(disk.synced, disk.bytes.size());
}

TEST(Writer, TheFileIsTouchedOncePerChunkAndNeverPerMessage) {
  Disk disk;
  SampleWriter out(disk, {.chunk_bytes = 64 << 10});
  out.add_channel("/a");
  int inside = 0;
  disk.on_append = [&] { ++inside; };
  const int before = disk.appends;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const int calls = inside;
    const std::uint64_t chunks = out.writer().counters().chunks;
    ASSERT_TRUE(out.write("/a", i, 100));
    ASSERT_EQ(inside - calls, static_cast<int>(out.writer().counters().chunks - chunks));  // a stall is felt only there
  }
  EXPECT_EQ(disk.appends - before, static_cast<int>(out.writer().counters().chunks));
  EXPECT_GT(inside, 5);
}

TEST(Writer, AMessageOfPiecesIsOneMessage) {
  Disk disk;
  SampleWriter out(disk, {});
  const std::string head(40, 'h'), pixels(100'000, 'p'), tail(30, 't');
  const auto image = *out.writer().add_channel("/image", "cdr", 0, {}, Packing::plain);
  const auto small = *out.writer().add_channel("/small", "cdr", 0);
  const std::span<const std::byte> large[] = {as_bytes(head), as_bytes(pixels), as_bytes(tail)};
  const std::span<const std::byte> pieces[] = {as_bytes(head), {}, as_bytes(tail)};
  ASSERT_TRUE(out.writer().write_parts(image, {1, 2, 3}, large));
  ASSERT_TRUE(out.writer().write_parts(small, {1, 2, 3}, pieces));
  ASSERT_TRUE(out.writer().finish());
  auto reader = open(disk.bytes);
  EXPECT_EQ(all(*reader, {.topics = {"/image"}}).samples.at(0).data, head + pixels + tail);
  EXPECT_EQ(all(*reader, {.topics = {"/small"}}).samples.at(0).data, head + tail);
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
}

TEST(Writer, AllocatesNothingPerMessageOnceItsChunksHaveTheirSize) {
  Disk disk;
  disk.bytes.reserve(64 << 20);
  SampleWriter out(disk, {.chunk_bytes = 256 << 10});
  out.add_channel("/a");
  out.add_channel("/b");
  out.add_channel("/image", Packing::plain);
  const std::string data(64, 'x'), image(100'000, 'y');
  const auto round = [&](std::uint64_t n) {
    const std::uint64_t before = test::allocations();
    for (std::uint64_t i = 0; i < 10'000; ++i) {
      const std::uint64_t t = n * 10'000 + i;
      EXPECT_TRUE(out.writer().write(out.id(i % 3 == 0 ? "/a" : "/b"), {0, t, t}, as_bytes(data)));
      if (i % 1000 == 0) {
        EXPECT_TRUE(out.writer().write(out.id("/image"), {0, t, t}, as_bytes(image)));
      }
    }
    return test::allocations() - before;
  };
  round(0), round(1);
  const std::uint64_t chunks = out.writer().counters().chunks;
  const std::uint64_t allocated = round(2);
  const std::uint64_t made = out.writer().counters().chunks - chunks;
  // A chunk index with its map of channels, and the list of all of them when it grows.
  EXPECT_LE(allocated, made * 4 + 4);
  EXPECT_GT(made, 10u);
}

TEST(Writer, RefusesWhatNoFileCanHold) {
  Disk disk;
  EXPECT_EQ(Writer::open(std::make_unique<MemoryOutput>(disk), {.chunk_bytes = 10}).error().code,
            hal::Errc::bad_argument);
  EXPECT_EQ(Writer::open(std::make_unique<MemoryOutput>(disk), {.chunk_duration = 0ms}).error().code,
            hal::Errc::bad_argument);
  EXPECT_EQ(Writer::open(std::make_unique<MemoryOutput>(disk), {.compression = Compression::zstd, .zstd_level = 99})
                .error()
                .code,
            hal::Errc::bad_argument);
  SampleWriter out(disk, {});
  EXPECT_EQ(out.writer().add_channel("/a", "cdr", 1).error().code, hal::Errc::bad_argument);
  EXPECT_EQ(out.writer().write(1, {}, {}).error().code, hal::Errc::bad_argument);
  const std::uint16_t id = *out.writer().add_channel("/a", "cdr", 0);
  const std::size_t size = Writer::kMaxDataBytes / Writer::kMaxParts;
  const auto never_read = std::make_unique_for_overwrite<std::byte[]>(size + 1);
  std::vector<std::span<const std::byte>> parts(Writer::kMaxParts, std::span(never_read.get(), size + 1));
  EXPECT_STREQ(out.writer().write_parts(id, {}, parts).error().where, "a message of more than 2^29 bytes");
  parts.assign(Writer::kMaxParts + 1, {});
  EXPECT_EQ(out.writer().write_parts(id, {}, parts).error().code, hal::Errc::bad_argument);
}

TEST(Writer, ASchemaThatNoChannelUsesIsInTheFile) {
  Disk disk;
  SampleWriter out(disk, {});
  ASSERT_TRUE(out.writer().add_schema("S", "ros2msg", "int8 x"));
  ASSERT_TRUE(out.writer().finish());
  EXPECT_THAT(check_bytes(disk.bytes), IsEmpty());
  EXPECT_EQ(open(disk.bytes)->schemas().at(1).name, "S");
}

TEST(Writer, GoesOnInAnotherFileThatIsWholeByItself) {
  Disk first, second;
  SampleWriter out(first, {.chunk_bytes = 1500});
  out.add_channel("/a");
  out.add_channel("/b", Packing::plain);
  for (std::uint64_t i = 0; i < 40; ++i) ASSERT_TRUE(out.write(i % 2 == 0 ? "/a" : "/b", i, 100));
  EXPECT_EQ(out.writer().first_time(), 0u);
  EXPECT_EQ(out.writer().last_time(), 39u);
  std::unique_ptr<hal::OutputFile> former;
  first.stalls = true;
  ASSERT_TRUE(out.writer().continue_in(std::make_unique<MemoryOutput>(second), former));
  ASSERT_TRUE(former);
  EXPECT_EQ(first.waits, 0) << "for the caller to wait, if it wants to";
  for (std::uint64_t i = 40; i < 70; ++i) ASSERT_TRUE(out.write(i % 2 == 0 ? "/a" : "/b", i, 100));
  EXPECT_EQ(out.writer().first_time(), 40u);
  ASSERT_TRUE(out.writer().finish());
  EXPECT_EQ(out.writer().counters().messages, 70u);
  std::vector<Sample> both;
  for (const Disk* disk : {&first, &second}) {
    EXPECT_THAT(check_bytes(disk->bytes), IsEmpty());
    auto reader = open(disk->bytes);
    EXPECT_EQ(reader->channels().size(), 2u);
    const auto read = all(*reader, {}).samples;
    both.insert(both.end(), read.begin(), read.end());
  }
  EXPECT_EQ(both, out.samples());
}

}  // namespace
}  // namespace sinew::record::writer_test
