// A file that is cut anywhere, or has any one bit wrong: whole messages are read, wrong ones are not, and missing ones
// are reported.
#include <set>

#include "qemu_user.hpp"
#include "record/recover.hpp"
#include "samples.hpp"

namespace sinew::record::damage_test {
namespace {

using testing::IsEmpty;

const bool kEverywhere = !kSanitized && !test::qemu_user();  // else one bit of each byte, every third cut

/// A small file with everything in it, and where its chunks are.
class Damage : public testing::TestWithParam<Compression> {
 protected:
  Damage() : out_(disk_, {.compression = GetParam(), .chunk_bytes = 1024}) {
    out_.add_channel("/imu");
    out_.add_channel("/image", Packing::plain);
    for (std::uint64_t i = 0; i < 24; ++i) {
      EXPECT_TRUE(out_.write("/imu", 1000 + i * 10, 60));
      if (i % 8 == 5) {
        EXPECT_TRUE(out_.write("/image", 1001 + i * 10, 350));
      }
      if (i == 12) {
        EXPECT_TRUE(out_.writer().attach({5, 6, "a.toml", "text/plain", "name = 1"}));
        EXPECT_TRUE(out_.writer().add_metadata({"robot", {{"name", "quad"}}}));
      }
    }
    EXPECT_TRUE(out_.writer().finish());
    auto reader = open(disk_.bytes);
    chunks_ = reader->chunks();
    whole_ = all(*reader, {.topics = {}, .order = Order::file}).samples;
    for (const ChunkIndex& chunk : chunks_) {
      // The content of a file that ends with this chunk.
      auto cut = open(std::span(disk_.bytes).first(static_cast<std::size_t>(chunk.offset + chunk.length)));
      up_to_.push_back(all(*cut, {.topics = {}, .order = Order::file}).samples.size());
    }
  }
  /// How many chunks end at or before this place.
  std::size_t chunks_before(std::uint64_t place) const {
    std::size_t n = 0;
    while (n < chunks_.size() && chunks_[n].offset + chunks_[n].length <= place) ++n;
    return n;
  }
  std::size_t samples_in(std::size_t chunks) const { return chunks == 0 ? 0 : up_to_[chunks - 1]; }

  Disk disk_;
  SampleWriter out_;
  std::vector<ChunkIndex> chunks_;
  std::vector<Sample> whole_;
  std::vector<std::size_t> up_to_;
};

TEST_P(Damage, TheFileHasSeveralChunksOfBothKinds) {
  ASSERT_GE(chunks_.size(), 5u);
  EXPECT_EQ(whole_.size(), 27u);
  EXPECT_EQ(up_to_.back(), 27u);
  EXPECT_THAT(check_bytes(disk_.bytes), IsEmpty());
}

TEST_P(Damage, CutAtAnyByteEverythingUpToTheLastWholeChunkIsRead) {
  for (std::size_t size = 0; size < disk_.bytes.size(); size += kEverywhere ? 1 : 3) {
    const auto bytes = std::span(disk_.bytes).first(size);
    FileProblem why;
    auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why);
    ASSERT_EQ(reader != nullptr, size >= kMagic.size()) << size;
    if (!reader) {
      EXPECT_EQ(why.kind, ProblemKind::not_mcap);
      continue;
    }
    const Contents read = all(*reader, {.topics = {}, .order = Order::file});
    const std::vector<Sample> wanted(whole_.begin(),
                                     whole_.begin() + static_cast<std::ptrdiff_t>(samples_in(chunks_before(size))));
    ASSERT_EQ(read.samples, wanted) << size;
    ASSERT_EQ(by_time(all(*reader, {}).samples), by_time(wanted)) << size;
    // Once its data are there, only the summary is missing, which no message depends on.
    const bool data_are_there = size >= disk_.bytes.size() - kFileTail || read.problems.empty();
    ASSERT_TRUE(data_are_there || !read.problems.empty()) << size;
    if (read.samples.size() < whole_.size()) {
      ASSERT_FALSE(read.problems.empty()) << size;
    }
    ASSERT_FALSE(check_bytes(bytes).empty()) << size;
  }
}

TEST_P(Damage, RecoveredFromACutAtAnyByteTheFileIsWhole) {
  for (std::size_t size = 0; size < disk_.bytes.size(); size += kEverywhere ? 1 + size % 3 : 7) {
    Disk recovered;
    Recovered result;
    const auto done = recover(std::make_unique<MemoryInput>(std::span(disk_.bytes).first(size)),
                              std::make_unique<MemoryOutput>(recovered), result);
    ASSERT_EQ(bool(done), size >= kMagic.size()) << size;
    if (!done) continue;
    ASSERT_THAT(check_bytes(recovered.bytes), IsEmpty()) << size;
    auto reader = open(recovered.bytes);
    ASSERT_TRUE(reader->by_summary());
    const std::vector<Sample> wanted(whole_.begin(),
                                     whole_.begin() + static_cast<std::ptrdiff_t>(samples_in(chunks_before(size))));
    ASSERT_THAT(all(*reader, {}).samples, testing::UnorderedElementsAreArray(wanted)) << size;
    ASSERT_EQ(result.messages, wanted.size());
  }
}

/// Flips every bit and reads the rest. `may_miss(place, chunk)`: whether this may cost the messages of that chunk.
template <class MayMiss>
void flip_every_bit(Bytes bytes, const std::vector<Sample>& whole, const std::vector<std::size_t>& up_to,
                    const std::vector<ChunkIndex>& chunks, const MayMiss& may_miss) {
  for (std::size_t place = 0; place < bytes.size(); ++place) {
    for (int bit = 0; bit < 8; ++bit) {
      if (!kEverywhere && bit != static_cast<int>(place * 5 % 8)) continue;
      const std::byte flip{static_cast<unsigned char>(1 << bit)};
      bytes[place] ^= flip;
      FileProblem why;
      auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why);
      const Contents read = reader ? all(*reader, {.topics = {}, .order = Order::file}) : Contents{};
      bytes[place] ^= flip;
      // In the order of the file, nothing that was not written, and nothing twice.
      std::size_t at = 0;
      std::vector<bool> found(whole.size(), false);
      for (const Sample& s : read.samples) {
        while (at < whole.size() && whole[at] != s) ++at;
        ASSERT_LT(at, whole.size()) << "byte " << place << " bit " << bit << ": a message that was never written";
        found[at++] = true;
      }
      for (std::size_t chunk = 0, i = 0; chunk < chunks.size(); ++chunk)
        for (; i < up_to[chunk]; ++i)
          ASSERT_TRUE(found[i] || may_miss(place, chunks[chunk]))
              << "byte " << place << " bit " << bit << ": message " << i << " of the chunk at " << chunks[chunk].offset;
      if (read.samples.size() < whole.size()) {
        ASSERT_TRUE(!reader || !read.problems.empty() || !reader->problems().empty())
            << "byte " << place << " bit " << bit << ": lost in silence";
      }
    }
  }
}

TEST_P(Damage, OneBitWrongCostsAtMostTheChunkItIsIn) {
  flip_every_bit(disk_.bytes, whole_, up_to_, chunks_, [](std::size_t place, const ChunkIndex& chunk) {
    return place >= chunk.offset && place < chunk.offset + chunk.length;
  });
}

TEST_P(Damage, WithoutASummaryOneBitWrongLeavesEverythingBeforeIt) {
  const auto end = chunks_.back().offset + chunks_.back().length + chunks_.back().message_index_length;
  const Bytes cut(disk_.bytes.begin(), disk_.bytes.begin() + static_cast<std::ptrdiff_t>(end));
  flip_every_bit(cut, whole_, up_to_, chunks_,
                 [](std::size_t place, const ChunkIndex& chunk) { return place < chunk.offset + chunk.length; });
}

TEST_P(Damage, EveryWrongBitIsFoundByCheck) {
  Bytes bytes = disk_.bytes;
  for (std::size_t place = 0; place < bytes.size(); ++place)
    for (int bit = 0; bit < 8; ++bit) {
      if (!kEverywhere && bit != static_cast<int>(place * 5 % 8)) continue;
      const std::byte flip{static_cast<unsigned char>(1 << bit)};
      bytes[place] ^= flip;
      const auto problems = check_bytes(bytes);
      bytes[place] ^= flip;
      ASSERT_FALSE(problems.empty()) << "byte " << place << " bit " << bit;
    }
}

TEST_P(Damage, CheckSaysWhatAndWhere) {
  const auto& chunk = chunks_[1];
  const auto at = std::to_string(chunk.offset);
  Bytes bytes = disk_.bytes;
  bytes.at(static_cast<std::size_t>(chunk.offset + chunk.length - 12)) ^= std::byte{4};  // in its records
  EXPECT_THAT(to_string(check_bytes(bytes).at(0)),
              testing::AnyOf("offset " + at + ": bad checksum: the chunk's bytes are not those that were written",
                             "offset " + at + ": bad compression: damaged " + to_string(GetParam()) + " frame"));
  EXPECT_THAT(to_string(check_bytes({}).at(0)), "offset 0: cut off: 8 bytes wanted, the file has 0 in all");
}

TEST_P(Damage, ADamagedChunkIsToldWhileTheRestIsRecovered) {
  const auto& chunk = chunks_[1];
  Bytes bytes = disk_.bytes;
  bytes.at(static_cast<std::size_t>(chunk.offset + chunk.length - 12)) ^= std::byte{4};
  Disk recovered;
  Recovered result;
  ASSERT_TRUE(recover(std::make_unique<MemoryInput>(bytes), std::make_unique<MemoryOutput>(recovered), result));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].offset, chunk.offset);
  EXPECT_EQ(result.messages, whole_.size() - (up_to_[1] - up_to_[0]));
  EXPECT_EQ(result.attachments, 1u);
  EXPECT_EQ(result.metadata, 1u);
  EXPECT_THAT(check_bytes(recovered.bytes), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Compressions, Damage, kCompressions, compression_name);

}  // namespace
}  // namespace sinew::record::damage_test
