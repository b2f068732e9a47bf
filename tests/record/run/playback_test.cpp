// A recorded file as topics in memory, read as other programs read them.
#include "record/run/playback.hpp"

#include <gmock/gmock.h>

#include <cstring>

#include "../memory_file.hpp"
#include "hal/platform.hpp"
#include "msg/all.hpp"
#include "msg/cdr.hpp"
#include "msg/image_buffer.hpp"
#include "msg/ros2msg.hpp"
#include "msg/sensors.hpp"
#include "record/run/run_messages.hpp"
#include "record/writer.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::record::playback_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using State = Playback::State;

constexpr std::int64_t kUnix_ns = 1'700'000'000'000'000'000;
constexpr std::uint32_t kWidth = 8, kHeight = 4;
constexpr int kRanges = 1000, kImages = 100;  // every 1 ms, every 10 ms; pixels of every second image

template <class M>
std::vector<std::byte> cdr_of(const M& message) {
  const msg::TypeInfo& type = msg::type_info<M>();
  std::vector<std::uint8_t> bytes(msg::cdr_size(type, &message));
  EXPECT_EQ(msg::cdr_encode(type, &message, bytes), bytes.size());
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

rt::Time at_ms(int ms) { return rt::Time{} + std::chrono::milliseconds(ms); }

/// Number i has its time in its range.
msg::RangeSample range_of(int i) {
  msg::RangeSample sample;
  sample.stamp = at_ms(i);
  sample.range_m = i;
  return sample;
}

/// One second: `tof.range`, `eye.image`, and a single `baro.sample` after 100 ms.
class File {
 public:
  File() {
    WriterOptions options;
    options.chunk_duration = 50ms;
    auto opened = Writer::open(std::make_unique<MemoryOutput>(disk_), options);
    writer_ = std::move(*opened);
    EXPECT_TRUE(writer_->add_metadata({"sinew.run", {{"unix_ns", std::to_string(kUnix_ns)}}}));
    const auto range = channel_of<msg::RangeSample>("tof.range"), baro = channel_of<msg::BaroSample>("baro.sample");
    const auto pixels = channel("eye.image", image_schema()), head = channel("eye.image/head", image_head_schema());
    const auto foreign = channel("other.topic", {"other_msgs/msg/Thing", "int32 number\n"});
    for (int i = 0; i < kRanges; ++i) {
      write(range, static_cast<std::uint32_t>(i + 1), i, cdr_of(range_of(i)));
      if (i == 100) write(baro, 1, i, cdr_of(msg::BaroSample{}));
      if (i == 100) write(foreign, 1, i, std::vector<std::byte>(8));
      if (i % 10 == 0) write_image(pixels, head, i / 10, i);
    }
    EXPECT_TRUE(writer_->finish());
  }
  Bytes& bytes() { return disk_.bytes; }

 private:
  template <class M>
  std::uint16_t channel_of(const char* topic) {
    const msg::TypeInfo& type = msg::type_info<M>();
    return channel(topic, {msg::ros2_name(type), msg::ros2msg_schema(type)});
  }
  std::uint16_t channel(const char* topic, const RecordSchema& schema) {
    const std::string name(schema.name), text(schema.text);
    return *writer_->add_channel(topic, "cdr", *writer_->add_schema(name, "ros2msg", text));
  }
  void write(std::uint16_t channel, std::uint32_t sequence, int ms, std::span<const std::byte> data) {
    const auto log_time = static_cast<std::uint64_t>(kUnix_ns + at_ms(ms).ns);
    ASSERT_TRUE(writer_->write(channel, {sequence, log_time, log_time}, data));
  }
  void write_image(std::uint16_t pixels, std::uint16_t heads, int number, int ms) {
    msg::ImageBuffer image(kWidth * kHeight);
    ASSERT_TRUE(image->format_as(msg::PixelFormat::mono8, kWidth, kHeight));
    image->stamp = at_ms(ms);
    image->frame_number = static_cast<std::uint32_t>(number);
    std::fill_n(image->pixels(), kWidth * kHeight, static_cast<std::uint8_t>(number));
    const bool whole = number % 2 == 0;
    Buffer to;
    encode_image_head(to, *image, kUnix_ns, "eye");
    std::vector<std::byte> data(to.bytes().begin(), to.bytes().end());
    const auto raw = std::as_bytes(std::span(image->pixels(), kWidth * kHeight));
    data.insert(data.end(), raw.begin(), raw.end());
    const auto sequence = static_cast<std::uint32_t>(number + 1);
    if (whole) write(pixels, sequence, ms, data);
    encode(to, head_of(*image, whole));
    write(heads, sequence, ms, to.bytes());
  }

  Disk disk_;
  std::unique_ptr<Writer> writer_;
};

/// Plays the file, and reads its topics as another program does.
class Played : public ::testing::Test {
 protected:
  void open(PlaybackOptions options = {}) {
    FileProblem why;
    reader_ = Reader::open(std::make_unique<MemoryInput>(file.bytes()), why);
    ASSERT_TRUE(reader_) << to_string(why);
    auto opened = Playback::open(*reader_, recorded_topics(*reader_).known, std::move(options), hal::system_os());
    ASSERT_TRUE(opened) << opened.error().where;
    playback = std::move(*opened);
    auto seen = tap::SegmentReader::open(
        {reinterpret_cast<const std::byte*>(&playback->segment().header()), playback->memory().size()});
    ASSERT_TRUE(seen) << seen.error().where;
    outside.emplace(std::move(*seen));
    ASSERT_TRUE(playback->start());
  }
  void open_paused() {
    PlaybackOptions options;
    options.paused = true;
    open(std::move(options));
  }
  /// Waits until a request is done.
  void done(std::uint64_t number) {
    while (playback->done() < number) hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  }
  void ended() {
    while (playback->status().state != State::ended) hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  }
  std::uint32_t topic(const char* name) { return *outside->find(name); }
  /// The newest message of a topic, copied; empty before the first.
  std::vector<std::byte> newest(const char* name) {
    std::vector<std::byte> copy(outside->bytes(topic(name)));
    const auto message = outside->newest(topic(name));
    if (!message) return {};
    EXPECT_TRUE(outside->copy(*message, copy)) << "nobody writes now";
    return copy;
  }
  std::uint32_t sequence(const char* name) {
    const auto message = outside->newest(topic(name));
    return message ? message->sequence : 0;
  }
  /// Of the newest message; below 0: there is none.
  double range() {
    const auto copy = newest("tof.range");
    if (copy.empty()) return -1;
    msg::RangeSample sample;
    std::memcpy(&sample, copy.data() + sizeof(rt::SlotHeader), sizeof sample);
    return sample.range_m;
  }
  int image() {
    const auto copy = newest("eye.image");
    if (copy.empty()) return -1;
    const auto* pixels = copy.data() + sizeof(rt::SlotHeader) + sizeof(msg::Image);
    for (std::uint32_t i = 1; i < kWidth * kHeight; ++i) EXPECT_EQ(pixels[i], pixels[0]) << "torn";
    return std::to_integer<int>(pixels[0]);
  }

  File file;

 private:
  std::unique_ptr<Reader> reader_;

 protected:
  std::unique_ptr<Playback> playback;
  std::optional<tap::SegmentReader> outside;
};

TEST_F(Played, EveryMessageHasTheBytesAndTheTimeOfTheFile) {
  PlaybackOptions options;
  options.paused = true;
  options.history["tof.range"] = kRanges;
  open(std::move(options));
  done(playback->step(1'000'000));
  EXPECT_EQ(playback->status().state, State::ended);
  tap::Cursor cursor{.next = 1, .started = true};
  std::vector<std::byte> copy(outside->bytes(topic("tof.range")));
  for (int i = 0; i < kRanges; ++i) {
    const auto message = outside->next(topic("tof.range"), cursor);
    ASSERT_TRUE(message);
    ASSERT_TRUE(outside->copy(*message, copy));
    rt::SlotHeader header;
    std::memcpy(&header, copy.data(), sizeof header);
    EXPECT_EQ(header.published, at_ms(i)) << "the recorded robot's clock";
    EXPECT_EQ(header.stamp, at_ms(i));
    const msg::RangeSample expected = range_of(i);
    ASSERT_EQ(std::memcmp(copy.data() + sizeof header, &expected, sizeof expected), 0) << i;
  }
  EXPECT_EQ(cursor.lost, 0u);
  EXPECT_EQ(image(), kImages - 2) << "the last one with pixels";
  EXPECT_EQ(playback->status().without_pixels, static_cast<std::uint64_t>(kImages / 2));
  EXPECT_EQ(playback->status().messages, static_cast<std::uint64_t>(kRanges + kImages / 2 + 1));
  EXPECT_EQ(playback->status().unfit, 0u);
}

TEST_F(Played, TypesThatTheProgramDoesNotHaveAreNamedWithTheReason) {
  FileProblem why;
  const auto reader = Reader::open(std::make_unique<MemoryInput>(file.bytes()), why);
  const RecordedTopics topics = recorded_topics(*reader);
  ASSERT_EQ(topics.unknown.size(), 1u);
  EXPECT_EQ(topics.unknown[0].name, "other.topic");
  EXPECT_EQ(topics.unknown[0].why, "other_msgs/msg/Thing: no message type of this program");
  EXPECT_EQ(topics.known.size(), 3u);
}

TEST_F(Played, WithoutAHistoryATopicKeepsHalfASecond) {
  open_paused();
  EXPECT_NEAR(outside->topics()[topic("tof.range")].keep, 501, 2);
  EXPECT_GE(outside->topics()[topic("baro.sample")].keep, 5u);
}

TEST_F(Played, AStepPublishesOneMessageAndStaysThere) {
  open_paused();
  EXPECT_EQ(range(), -1) << "nothing is played yet";
  done(playback->step(1));
  EXPECT_EQ(range(), 0);
  done(playback->step(2));
  EXPECT_EQ(playback->status().messages, 3u);
  const auto status = playback->status();
  EXPECT_EQ(status.state, State::paused);
  EXPECT_EQ(status.now, at_ms(static_cast<int>(range())));
}

TEST_F(Played, StepsThatAreAskedForTogetherAreAllDone) {
  open_paused();
  playback->step(300);
  playback->step(300);
  done(playback->step(7));
  EXPECT_EQ(playback->status().messages, 607u);
}

TEST_F(Played, AnotherRequestEndsAStepThatGoesOn) {
  PlaybackOptions options;
  options.paused = true;
  options.other_topics = {"other.topic"};  // after 100 ms the step is held up there until the pause is asked for
  std::atomic<bool> is_asked{false};
  options.other = [&](const Message&) {
    while (!is_asked) hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  };
  open(std::move(options));
  const auto step = playback->step(1'000'000);
  const auto pause = playback->pause();
  is_asked = true;
  done(pause);
  EXPECT_GE(playback->done(), step);
  EXPECT_LT(playback->status().messages, 600u) << "a group of messages at most";
  EXPECT_EQ(playback->status().state, State::paused);
  playback.reset();
}

TEST_F(Played, AStepToATopicPublishesEverythingBeforeIt) {
  open_paused();
  for (std::size_t t = 0; t < playback->topics().size(); ++t)
    if (playback->topics()[t].name == "baro.sample") done(playback->step_to(t));
  EXPECT_EQ(sequence("baro.sample"), 1u);
  EXPECT_EQ(range(), 100);
  EXPECT_EQ(playback->status().now, at_ms(100));
}

TEST_F(Played, AStepToATopicWithoutFurtherMessagesEndsAtTheEnd) {
  open_paused();
  done(playback->seek(at_ms(500)));
  for (std::size_t t = 0; t < playback->topics().size(); ++t)
    if (playback->topics()[t].name == "baro.sample") done(playback->step_to(t));
  EXPECT_EQ(playback->status().state, State::ended);
  EXPECT_EQ(range(), kRanges - 1);
}

TEST_F(Played, ASeekShowsTheNewestMessageOfEachTopicAtOnce) {
  open_paused();
  done(playback->seek(at_ms(705)));
  EXPECT_EQ(range(), 705);
  EXPECT_EQ(image(), 70) << "whole, with its pixels, though number 71 has only a head";
  EXPECT_EQ(sequence("baro.sample"), 1u) << "600 ms old, in another chunk";
  EXPECT_EQ(playback->status().now, at_ms(705));
  EXPECT_EQ(playback->status().messages, 3u);
  done(playback->step(1));
  EXPECT_EQ(range(), 706) << "the rest follows";
}

TEST_F(Played, SequencesRiseWhenTheTimeGoesBack) {
  open_paused();
  done(playback->seek(at_ms(800)));
  const auto range_before = sequence("tof.range"), image_before = sequence("eye.image");
  done(playback->seek(at_ms(300)));
  EXPECT_EQ(range(), 300);
  EXPECT_EQ(image(), 30);
  EXPECT_EQ(sequence("tof.range"), range_before + 1);
  EXPECT_EQ(sequence("eye.image"), image_before + 1);
  done(playback->seek(at_ms(0)));
  EXPECT_EQ(range(), 0);
}

TEST_F(Played, ASeekOutsideIsToTheNearestEnd) {
  open_paused();
  done(playback->seek(rt::Time{INT64_MAX}));
  EXPECT_EQ(range(), kRanges - 1);
  EXPECT_EQ(playback->status().now, at_ms(kRanges - 1));
  done(playback->seek(rt::Time{INT64_MIN}));
  EXPECT_EQ(playback->status().now, at_ms(0));
}

TEST_F(Played, EverythingIsPlayedInItsOrderUpToTheEnd) {
  PlaybackOptions options;
  options.speed = 100;
  options.history["tof.range"] = kRanges;
  open(std::move(options));
  ended();
  EXPECT_EQ(sequence("tof.range"), static_cast<std::uint32_t>(kRanges)) << "each once";
  EXPECT_EQ(range(), kRanges - 1);
  EXPECT_EQ(playback->status().now, at_ms(kRanges - 1));
  done(playback->play());
  ended();
  EXPECT_EQ(sequence("tof.range"), static_cast<std::uint32_t>(2 * kRanges)) << "play after the end begins again";
}

TEST_F(Played, ThePauseStopsTimeAndMessages) {
  open();
  done(playback->pause());
  const auto before = playback->status();
  EXPECT_EQ(before.state, State::paused);
  hal::system_os().sleep_until(hal::system_os().now() + 30ms);
  EXPECT_EQ(playback->status().now, before.now);
  EXPECT_EQ(playback->status().messages, before.messages);
  EXPECT_GE(before.now, at_ms(static_cast<int>(range()))) << "what is shown is not of the future";
  done(playback->step(1));
  EXPECT_EQ(playback->status().messages, before.messages + 1) << "nothing is left out or shown twice";
}

TEST_F(Played, TheSpeedIsHeldInItsLimits) {
  open_paused();
  done(playback->set_speed(0));
  EXPECT_EQ(playback->status().speed, Playback::kSlowest);
  done(playback->set_speed(1e9));
  EXPECT_EQ(playback->status().speed, Playback::kFastest);
  EXPECT_EQ(playback->status().now, at_ms(0));
}

TEST_F(Played, ALoopBeginsAgainAndNeverEnds) {
  PlaybackOptions options;
  options.speed = 100, options.loop = true;
  open(std::move(options));
  while (playback->status().rounds < 3) {
    EXPECT_NE(playback->status().state, State::ended);
    hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  }
  EXPECT_GE(sequence("tof.range"), static_cast<std::uint32_t>(3 * kRanges));
}

TEST_F(Played, APartOfTheFileBeginsWithWhatWasShownThen) {
  PlaybackOptions options;
  options.from = static_cast<std::uint64_t>(kUnix_ns + at_ms(400).ns);
  options.until = static_cast<std::uint64_t>(kUnix_ns + at_ms(600).ns);
  options.paused = true;
  open(std::move(options));
  EXPECT_EQ(playback->status().begin, at_ms(400));
  done(playback->step(1));
  EXPECT_EQ(range(), 400);
  EXPECT_EQ(image(), 38) << "the newest before it";
  done(playback->seek(at_ms(100)));
  EXPECT_EQ(playback->status().now, at_ms(400));
  done(playback->step(1'000'000));
  EXPECT_EQ(range(), 600);
}

TEST_F(Played, AFileWithoutItsEndPlaysAsFarAsItGoesAndSaysSo) {
  file.bytes().resize(file.bytes().size() / 2);
  open_paused();
  done(playback->step(1'000'000));
  EXPECT_GT(range(), 100);
  EXPECT_LT(range(), kRanges - 1);
  EXPECT_FALSE(playback->status().problems.empty());
  const double last = range();
  done(playback->seek(at_ms(105)));
  EXPECT_EQ(range(), 105);
  done(playback->step(1'000'000));
  EXPECT_EQ(range(), last);
}

TEST_F(Played, ADamagedChunkIsLeftOutAndNamedOnce) {
  for (std::size_t i = 0; i < 64; ++i) file.bytes()[file.bytes().size() / 2 + i] ^= std::byte{0x5a};
  open_paused();
  done(playback->step(1'000'000));
  const auto problems = playback->status().problems.size();
  EXPECT_GE(problems, 1u);
  EXPECT_EQ(range(), kRanges - 1) << "what is behind it is played";
  EXPECT_LT(playback->status().messages, static_cast<std::uint64_t>(kRanges));
  done(playback->seek(at_ms(0)));
  done(playback->step(1'000'000));
  EXPECT_EQ(playback->status().problems.size(), problems);
}

TEST_F(Played, OtherTopicsAreHandedOnWhenTheyAreDue) {
  PlaybackOptions options;
  options.paused = true;
  options.other_topics = {"other.topic"};
  std::atomic<int> others{0};
  options.other = [&](const Message& m) {
    EXPECT_EQ(m.channel->topic, "other.topic");
    ++others;
  };
  open(std::move(options));
  done(playback->step(50));
  EXPECT_EQ(others, 0);
  done(playback->step(1'000'000));
  EXPECT_EQ(others, 1);
  playback.reset();
}

}  // namespace
}  // namespace sinew::record::playback_test
