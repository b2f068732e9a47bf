// Files of other writers, and files that no writer should make.
#include "record/reader.hpp"

#include "record/crc32.hpp"
#include "record/recover.hpp"
#include "samples.hpp"

namespace sinew::record::reader_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A file made record by record.
class Hand {
 public:
  Hand() {
    bytes_.append(kMagic);
    encode(bytes_, Header{"", "by hand"});
  }
  static void put_message(Buffer& to, std::uint16_t channel, std::uint64_t time, std::string_view data) {
    encode_message_head(to.extend(kMessageHead), channel, {1, time, time}, data.size());
    to.append(as_bytes(data));
  }
  static void put_unknown(Buffer& to, std::uint8_t op, std::size_t size) {
    to.number(op), to.number(std::uint64_t{size});
    for (std::size_t i = 0; i < size; ++i) to.number(std::uint8_t{0xAB});
  }
  static void define(Buffer& to, std::uint16_t id = 1, const std::string& topic = "/t") {
    encode(to, Schema{1, "S", "ros2msg", "int8 x"});
    encode(to, Channel{id, 1, topic, "cdr", {}});
  }
  Buffer& bytes() { return bytes_; }
  /// An uncompressed chunk; its index for the summary.
  ChunkIndex put_chunk(const Buffer& records, std::uint64_t start, std::uint64_t end, const std::string& name = "") {
    const std::uint64_t at = bytes_.size();
    encode_head(bytes_, ChunkHead{start, end, records.size(), crc32(records.bytes()), name, records.size()});
    bytes_.append(records.bytes());
    return {start, end, at, bytes_.size() - at, {}, 0, name, records.size(), records.size()};
  }
  void put_data_end() {
    bytes_.number(static_cast<std::uint8_t>(Op::data_end)), bytes_.number(std::uint64_t{4});
    bytes_.number(std::uint32_t{0});
  }
  std::span<const std::byte> finish(const Summary& summary = {}) {
    put_data_end();
    encode_end(bytes_, summary, bytes_.size());
    return bytes_.bytes();
  }

 private:
  Buffer bytes_;
};

Summary definitions() {
  Summary summary;
  summary.schemas[1] = {1, "S", "ros2msg", "int8 x"};
  summary.channels[1] = {1, 1, "/t", "cdr", {}};
  return summary;
}

TEST(Reader, SkipsRecordsItDoesNotKnow) {
  Hand file;
  Buffer records;
  Hand::put_unknown(file.bytes(), 0x10, 20);
  Hand::put_unknown(records, 0x81, 5);
  Hand::define(records);
  Hand::put_unknown(records, 0x7F, 0);
  Hand::put_message(records, 1, 5, "abc");
  Summary summary = definitions();
  summary.chunks.push_back(file.put_chunk(records, 5, 5));
  Hand::put_unknown(file.bytes(), 0xFF, 100'000);
  const auto bytes = file.finish(summary);
  for (const auto part : {bytes, bytes.first(bytes.size() - 1)}) {  // by the summary, and by looking
    auto reader = open(part);
    EXPECT_EQ(reader->by_summary(), part.size() == bytes.size());
    const Contents read = all(*reader, {});
    ASSERT_THAT(read.samples, SizeIs(1));
    EXPECT_EQ(read.samples[0].data, "abc");
  }
  EXPECT_THAT(check_bytes(bytes), IsEmpty());
}

TEST(Reader, IgnoresWhatNewerFormatsAppendToARecord) {
  Hand file;
  Buffer records, longer;
  encode(longer, Channel{1, 0, "/t", "cdr", {}});
  longer.append(as_bytes("later"));
  Buffer::put(longer.data() + 1, std::uint64_t{longer.size() - kRecordHead});
  records.append(longer.bytes());
  Hand::put_message(records, 1, 5, "abc");
  file.put_chunk(records, 5, 5);
  EXPECT_EQ(all(*open(file.finish()), {}).samples.at(0).topic, "/t");
}

TEST(Reader, ReadsFilesWithoutChunks) {
  Hand file;
  Hand::define(file.bytes());
  for (std::uint32_t i = 0; i < 5000; ++i) Hand::put_message(file.bytes(), 1, 10'000 - i, std::string(i % 700, 'x'));
  const auto bytes = file.finish(definitions());
  auto reader = open(bytes);
  EXPECT_FALSE(reader->by_summary());
  EXPECT_EQ(reader->statistics()->messages, 5000u);
  const Contents read = all(*reader, {});
  ASSERT_THAT(read.samples, SizeIs(5000));
  for (std::uint32_t i = 0; i < 5000; ++i) ASSERT_EQ(read.samples[i].stamps.log_time, 5001 + i);
  EXPECT_EQ(all(*reader, {.topics = {}, .from = 6000, .until = 6009}).samples.size(), 10u);
  EXPECT_THAT(read.problems, IsEmpty());
}

TEST(Reader, ReadsTheSmallestFile) {
  Buffer bytes;
  bytes.append(kMagic);
  encode(bytes, Header{});
  encode_end(bytes, {}, bytes.size());
  auto reader = open(bytes.bytes());
  EXPECT_THAT(all(*reader, {}).samples, IsEmpty());
  EXPECT_THAT(all(*reader, {}).problems, IsEmpty());
}

TEST(Reader, ChunksThatOverlapComeOutInTheOrderOfTime) {
  Hand file;
  Summary summary = definitions();
  for (std::uint64_t c = 0; c < 5; ++c) {
    Buffer records;
    Hand::define(records);
    for (std::uint64_t i = 0; i < 20; ++i) Hand::put_message(records, 1, (19 - i) * 10 + c % 3, std::to_string(c));
    summary.chunks.push_back(file.put_chunk(records, c % 3, 190 + c % 3));
  }
  auto reader = open(file.finish(summary));
  EXPECT_TRUE(reader->by_summary());
  const auto read = all(*reader, {}).samples;
  ASSERT_THAT(read, SizeIs(100));
  for (std::size_t i = 1; i < read.size(); ++i) {
    ASSERT_LE(read[i - 1].stamps.log_time, read[i].stamps.log_time);
    if (read[i - 1].stamps.log_time == read[i].stamps.log_time) {
      ASSERT_LT(read[i - 1].data, read[i].data);  // as they stand in the file
    }
  }
}

TEST(Reader, MessagesOfUnknownChannelsAreToldAndTheOthersRead) {
  Hand file;
  Buffer records;
  Hand::define(records);
  Hand::put_message(records, 1, 5, "known");
  Hand::put_message(records, 9, 5, "unknown");
  file.put_chunk(records, 5, 5);
  const Contents read = all(*open(file.finish()), {});
  EXPECT_EQ(read.samples.at(0).data, "known");
  EXPECT_THAT(read.samples, SizeIs(1));
  EXPECT_EQ(to_string(read.problems.at(0)),
            "offset 32: unknown channel: 1 messages are of channels that were not defined before");
}

TEST(Reader, AChannelThatOnlyItsChunkDefinesIsReadAndRecovered) {
  Hand file;
  Buffer records;
  Hand::define(records);
  Hand::put_message(records, 1, 5, "abc");
  Summary summary;
  summary.chunks.push_back(file.put_chunk(records, 5, 5));
  const auto bytes = file.finish(summary);
  auto reader = open(bytes);
  ASSERT_TRUE(reader->by_summary());
  EXPECT_EQ(all(*reader, {.topics = {"/t"}}).samples.at(0).data, "abc");
  EXPECT_THAT(all(*reader, {.topics = {"/other"}}).samples, IsEmpty());
  Disk to;
  Recovered result;
  ASSERT_TRUE(recover(std::make_unique<MemoryInput>(bytes), std::make_unique<MemoryOutput>(to), result));
  EXPECT_EQ(all(*open(to.bytes), {.topics = {"/t"}}).samples.at(0).data, "abc");
  EXPECT_EQ(open(to.bytes)->schemas().at(1).data, "int8 x");
}

TEST(Reader, AChannelMayNotChange) {
  Hand file;
  Buffer first, second;
  Hand::define(first);
  Hand::put_message(first, 1, 5, "a");
  Hand::define(second, 1, "/other");
  Hand::put_message(second, 1, 6, "b");
  file.put_chunk(first, 5, 5);
  file.put_chunk(second, 6, 6);
  const Contents read = all(*open(file.finish()), {});
  EXPECT_THAT(read.samples, SizeIs(1));
  EXPECT_THAT(to_string(read.problems.at(0)), HasSubstr("bad record: channel 1 is not what it was before"));
}

TEST(Reader, UnknownCompressionsAreNamed) {
  Hand file;
  Buffer records;
  Hand::define(records);
  file.put_chunk(records, 0, 0, "bz2");
  const Contents read = all(*open(file.finish()), {});
  EXPECT_EQ(to_string(read.problems.at(0)), "offset 32: bad compression: 'bz2'; known are '' (none), 'lz4' and 'zstd'");
}

TEST(Reader, AnIndexThatLiesAboutTimesIsToldBeforeTheOrderIsWrong) {
  Hand file;
  Summary summary = definitions();
  Buffer records;
  Hand::define(records);
  Hand::put_message(records, 1, 500, "late");
  summary.chunks.push_back(file.put_chunk(records, 500, 500));
  summary.chunks.back().start_time = 5;
  auto reader = open(file.finish(summary));
  const Contents read = all(*reader, {});
  EXPECT_THAT(read.samples, IsEmpty());
  EXPECT_EQ(to_string(read.problems.at(0)),
            "offset 32: bad index: messages from 500 to 500, the index says from 5 to 500");
}

TEST(Reader, TakesNoMoreMemoryThanItWasGiven) {
  Hand file;
  Buffer records;
  Hand::define(records);
  Hand::put_message(records, 1, 5, std::string(5000, 'x'));
  file.put_chunk(records, 5, 5);
  const auto bytes = file.finish();
  EXPECT_THAT(all(*open(bytes, {.record_bytes = 100'000}), {}).samples, SizeIs(1));
  const Contents read = all(*open(bytes, {.record_bytes = 4000}), {});
  EXPECT_THAT(read.samples, IsEmpty());
  EXPECT_THAT(to_string(read.problems.at(0)), HasSubstr("too large: "));
}

TEST(Reader, ChunksThatAllOverlapAreRefusedBeyondTheLimitAndReadableInTheOrderOfTheFile) {
  Hand file;
  Summary summary = definitions();
  for (std::uint64_t c = 0; c < 10; ++c) {
    Buffer records;
    Hand::define(records);
    for (std::uint64_t i = 0; i < 2; ++i) Hand::put_message(records, 1, i * 100 + c, std::string(1000, 'x'));
    summary.chunks.push_back(file.put_chunk(records, c, 100 + c));
  }
  auto reader = open(file.finish(summary), {.open_bytes = 5000});
  EXPECT_THAT(to_string(all(*reader, {}).problems.at(0)), HasSubstr("overlap in log time; read them in the order"));
  EXPECT_THAT(all(*reader, {.topics = {}, .order = Order::file}).samples, SizeIs(20));
}

TEST(Reader, SizesBeyondTheFileAreNotBelieved) {
  Hand file;
  Buffer records;
  Hand::define(records);
  const ChunkIndex chunk = file.put_chunk(records, 0, 0);
  for (const std::uint64_t size : {std::uint64_t{records.size()} + 1, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    Buffer bytes;
    bytes.append(file.bytes().bytes());
    Buffer::put(bytes.data() + chunk.offset + 1, size);  // of the record
    EXPECT_FALSE(all(*open(bytes.bytes()), {}).problems.empty());
    bytes.clear();
    bytes.append(file.bytes().bytes());
    Buffer::put(bytes.data() + chunk.offset + kRecordHead + 16, size);  // of what it unpacks to
    EXPECT_FALSE(all(*open(bytes.bytes()), {}).problems.empty());
  }
}

TEST(Reader, WhatIsNoMcapFileIsSaidToBeNone) {
  FileProblem why;
  for (const char* text : {"", "no", "#!/bin/sh\necho a longer file that is something else altogether\n"})
    EXPECT_EQ(Reader::open(std::make_unique<MemoryInput>(as_bytes(text)), why), nullptr);
  EXPECT_EQ(to_string(why), "offset 0: not an MCAP file: it does not begin with \\x89MCAP0\\r\\n");
}

TEST(Reader, RecoveringAFileWithoutChunksGivesOneWithChunks) {
  Hand file;
  Hand::define(file.bytes());
  for (std::uint64_t i = 0; i < 100; ++i) Hand::put_message(file.bytes(), 1, i, "abc");
  Disk to;
  Recovered result;
  ASSERT_TRUE(recover(std::make_unique<MemoryInput>(file.bytes().bytes()), std::make_unique<MemoryOutput>(to), result));
  EXPECT_EQ(result.messages, 100u);
  EXPECT_TRUE(open(to.bytes)->by_summary());
  EXPECT_THAT(check_bytes(to.bytes), IsEmpty());
}

}  // namespace
}  // namespace sinew::record::reader_test
