// Every written message is read again: by the summary, by looking at everything, in both orders, with every
// compression.
#include "samples.hpp"

namespace sinew::record::round_trip_test {
namespace {

using testing::ElementsAreArray;
using testing::IsEmpty;

class RoundTrip : public testing::TestWithParam<Compression> {
 protected:
  RoundTrip() : out_(disk_, {.compression = GetParam(), .chunk_bytes = 4096}) {
    out_.add_channel("/imu");
    out_.add_channel("/image", Packing::plain);
    out_.add_channel("/never");
    for (std::uint32_t i = 0; i < 300; ++i) {
      EXPECT_TRUE(out_.write("/imu", 1000 + i * 10 - i % 3 * 4, 40 + i % 50));
      if (i % 20 == 7) {
        EXPECT_TRUE(out_.write("/image", 1000 + i * 10, i == 107 ? 100'000 : 900));
      }
    }
    EXPECT_TRUE(out_.writer().attach({5, 6, "robot.toml", "application/toml", "name = 1"}));
    EXPECT_TRUE(out_.writer().add_metadata({"robot", {{"name", "quad"}, {"seed", "4"}}}));
    EXPECT_TRUE(out_.writer().finish());
  }
  Disk disk_;
  SampleWriter out_;
};

TEST_P(RoundTrip, EveryMessageInTheOrderOfLogTime) {
  auto reader = open(disk_.bytes);
  EXPECT_TRUE(reader->by_summary());
  EXPECT_THAT(reader->problems(), IsEmpty());
  const Contents read = all(*reader, {});
  EXPECT_THAT(read.problems, IsEmpty());
  ASSERT_EQ(read.samples.size(), out_.samples().size());
  for (std::size_t i = 1; i < read.samples.size(); ++i)
    EXPECT_LE(read.samples[i - 1].stamps.log_time, read.samples[i].stamps.log_time);
  EXPECT_THAT(read.samples, testing::UnorderedElementsAreArray(out_.samples()));
}

TEST_P(RoundTrip, EachChannelInTheOrderOfWritingWhenReadInTheOrderOfTheFile) {
  auto reader = open(disk_.bytes);
  for (const char* topic : {"/imu", "/image"}) {
    std::vector<Sample> written;
    for (const Sample& s : out_.samples())
      if (s.topic == topic) written.push_back(s);
    EXPECT_THAT(all(*reader, {.topics = {topic}, .order = Order::file}).samples, ElementsAreArray(written));
  }
}

TEST_P(RoundTrip, ChecksWholeAndLooksTheSameWithoutItsSummary) {
  EXPECT_THAT(check_bytes(disk_.bytes), IsEmpty());
  auto whole = open(disk_.bytes);
  const std::uint64_t end = whole->metadata().back().offset + whole->metadata().back().length;
  auto cut = open(std::span(disk_.bytes).first(static_cast<std::size_t>(end)));
  EXPECT_FALSE(cut->by_summary());
  EXPECT_TRUE(cut->statistics() == whole->statistics());
  EXPECT_TRUE(cut->channels() == whole->channels());
  EXPECT_TRUE(cut->schemas() == whole->schemas());
  EXPECT_TRUE(cut->attachments() == whole->attachments());
  EXPECT_EQ(all(*cut, {}).samples, all(*whole, {}).samples);
  ASSERT_EQ(all(*cut, {}).problems.size(), 1u);
  EXPECT_EQ(to_string(all(*cut, {}).problems[0]),
            "offset " + std::to_string(end) + ": cut off: the file has no DataEnd");
}

TEST_P(RoundTrip, AttachmentsMetadataAndChannelsAsTheyWere) {
  auto reader = open(disk_.bytes);
  Attachment attachment;
  Metadata metadata;
  FileProblem why;
  ASSERT_EQ(reader->attachments().size(), 1u);
  ASSERT_TRUE(reader->read(reader->attachments()[0], attachment, why)) << to_string(why);
  EXPECT_EQ(attachment.name, "robot.toml");
  EXPECT_EQ(attachment.data, "name = 1");
  EXPECT_EQ(attachment.create_time, 6u);
  ASSERT_EQ(reader->metadata().size(), 1u);
  ASSERT_TRUE(reader->read(reader->metadata()[0], metadata, why)) << to_string(why);
  EXPECT_EQ(metadata.values, (Texts{{"name", "quad"}, {"seed", "4"}}));
  EXPECT_EQ(reader->header().library, "sinew");
  ASSERT_EQ(reader->channels().size(), 3u);
  EXPECT_EQ(reader->channels().at(3).topic, "/never");
  EXPECT_EQ(reader->channels().at(1).metadata, (Texts{{"note", "/imu"}}));
  EXPECT_EQ(reader->schemas().at(2).data, "float64 image");
  EXPECT_EQ(reader->statistics()->channel_messages.at(3), 0u);
}

TEST_P(RoundTrip, SeekingAndFilteringGiveTheSameAsReadingAll) {
  auto reader = open(disk_.bytes);
  const auto everything = by_time(all(*reader, {}).samples);
  for (std::uint64_t from : {0u, 1000u, 1001u, 2500u, 3986u, 9000u}) {
    std::vector<Sample> wanted;
    for (const Sample& s : everything)
      if (s.stamps.log_time >= from && s.stamps.log_time <= from + 700) wanted.push_back(s);
    EXPECT_THAT(all(*reader, {.topics = {}, .from = from, .until = from + 700}).samples, ElementsAreArray(wanted));
  }
  MessageReader messages = reader->messages({.topics = {"/imu"}});
  Message m;
  for (const std::uint64_t to : {3000u, 1500u, 2000u}) {  // backwards, too
    messages.seek(to);
    ASSERT_EQ(messages.next(m), Next::message);
    EXPECT_EQ(m.channel->topic, "/imu");
    EXPECT_GE(m.stamps.log_time, to);
    EXPECT_LE(m.stamps.log_time, to + 10);
  }
}

TEST_P(RoundTrip, PlainChannelsAreNeverCompressed) {
  auto reader = open(disk_.bytes);
  const std::string name = to_string(GetParam());
  for (const ChunkIndex& chunk : reader->chunks()) {
    const bool image = chunk.message_indexes.contains(out_.id("/image"));
    EXPECT_EQ(chunk.compression, image ? "" : name) << chunk.offset;
    if (image) {
      EXPECT_EQ(chunk.message_indexes.size(), 1u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Compressions, RoundTrip, kCompressions, compression_name);

}  // namespace
}  // namespace sinew::record::round_trip_test
