#include "record/run/run_messages.hpp"

#include <gtest/gtest.h>

#include "msg/image_buffer.hpp"

namespace sinew::record::messages_test {
namespace {

LoggedStep some_step(std::uint32_t number) {
  LoggedStep s;
  s.order = 1000 + number;
  s.thread = 3, s.module = 7, s.number = number, s.device_state = 0x80000001;
  s.release = {-5}, s.now = {number * 1000 + 1}, s.completed = {number * 1000 + 900};
  s.dt = rt::Duration{1000}, s.exec = rt::Duration{899};
  s.status = rt::StepStatus::stale;
  s.timed_out = number % 2 == 1;
  s.inputs.resize(2);
  s.inputs[0].port = 1, s.inputs[0].updated = true, s.inputs[0].sequences = {0xFFFFFFFF, 0, 5};
  s.inputs[1].port = 2, s.inputs[1].dropped = 9;
  s.outputs.resize(number % 3);
  for (auto& out : s.outputs) out.port = 4, out.first = 0xFFFFFFFE, out.count = 3, out.origin_ns = {INT64_MAX, -1};
  return s;
}

TEST(StepBatch, ComesBackAsItWas) {
  StepBatch batch;
  std::vector<LoggedStep> steps, read;
  for (int round = 0; round < 2; ++round) {  // the second one over the memory of the first
    steps.clear();
    for (std::uint32_t n = 0; n < 5; ++n) {
      steps.push_back(some_step(n + static_cast<std::uint32_t>(round)));
      batch.add(steps.back());
    }
    EXPECT_EQ(batch.count(), 5u);
    EXPECT_EQ(batch.first(), steps.front().now);
    ASSERT_TRUE(decode(batch.bytes(), read));
    EXPECT_EQ(read, steps);
    batch.clear();
    EXPECT_TRUE(batch.empty());
  }
}

TEST(StepBatch, AnyCutIsNoBatchAndNeverMore) {
  StepBatch batch;
  for (std::uint32_t n = 0; n < 3; ++n) batch.add(some_step(n));
  std::vector<LoggedStep> read;
  for (std::size_t size = 0; size < batch.bytes().size(); ++size) {
    EXPECT_FALSE(decode(batch.bytes().first(size), read)) << size;
    EXPECT_TRUE(read.empty());
  }
  std::vector<std::byte> longer(batch.bytes().begin(), batch.bytes().end());
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode(longer, read));
}

TEST(LoggedRequest, ComesBackAsItWas) {
  using Kind = rt::Request::Kind;
  const std::variant<bool, std::int64_t, double> values[] = {true, std::int64_t{-7}, 0.1};
  for (const auto& value : values) {
    LoggedRequest r;
    r.order = 12;
    r.request.kind = Kind::set_period;
    r.request.thread = 2, r.request.module = 5, r.request.index = 1, r.request.value = value;
    r.effect = {77, true};
    r.now = {123456789012345};
    Buffer bytes;
    encode(bytes, r);
    LoggedRequest read;
    ASSERT_TRUE(decode(bytes.bytes(), read));
    EXPECT_EQ(read.order, r.order);
    EXPECT_EQ(read.now, r.now);
    EXPECT_EQ(read.request.kind, r.request.kind);
    EXPECT_EQ(read.request.thread, r.request.thread);
    EXPECT_EQ(read.request.module, r.request.module);
    EXPECT_EQ(read.request.index, r.request.index);
    EXPECT_EQ(read.request.value, r.request.value);
    EXPECT_EQ(read.effect, r.effect);
    for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode(bytes.bytes().first(size), read));
  }
}

TEST(LoggedState, ComesBackAsItWas) {
  const std::byte some[] = {std::byte{1}, std::byte{2}, std::byte{3}};
  LoggedState s;
  s.order = 9, s.thread = 1, s.module = 2, s.number = 3, s.completed = {-4}, s.bytes = some;
  Buffer bytes;
  encode(bytes, s, 0xFEDCBA9876543210);
  LoggedState read;
  std::uint64_t layout = 0;
  ASSERT_TRUE(decode(bytes.bytes(), read, layout));
  EXPECT_EQ(layout, 0xFEDCBA9876543210);
  EXPECT_EQ(std::tuple(read.order, read.thread, read.module, read.number, read.completed),
            std::tuple(s.order, s.thread, s.module, s.number, s.completed));
  EXPECT_TRUE(std::equal(read.bytes.begin(), read.bytes.end(), std::begin(some), std::end(some)));
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode(bytes.bytes().first(size), read, layout));
}

TEST(Image, IsTheImageThatOthersKnowAndComesBack) {
  msg::ImageBuffer buffer(64);
  msg::Image& image = *buffer;
  ASSERT_TRUE(image.format_as(msg::PixelFormat::yuyv, 4, 2));
  image.stamp = {1'700'000'001'000'000'002 - 40};
  image.exposure_ns = 5, image.frame_number = 6;
  for (std::uint32_t i = 0; i < image.bulk_used(); ++i) image.pixels()[i] = static_cast<std::uint8_t>(i * 3);
  Buffer bytes;
  encode_image_head(bytes, image, 40, "cam");
  // By hand, from sensor_msgs/msg/Image: sec, nanosec, frame_id, height, width, encoding, bigendian, step, length.
  const unsigned char expected[] = {0,   1, 0,   0,   1,   0xF1, 0x53, 0x65, 2,   0,   0,   0,   4,   0,
                                    0,   0, 'c', 'a', 'm', 0,    2,    0,    0,   0,   4,   0,   0,   0,
                                    12,  0, 0,   0,   'y', 'u',  'v',  '4',  '2', '2', '_', 'y', 'u', 'y',
                                    '2', 0, 0,   0,   0,   0,    8,    0,    0,   0,   16,  0,   0,   0};
  ASSERT_EQ(bytes.size(), sizeof expected);
  EXPECT_EQ(std::memcmp(bytes.data(), expected, sizeof expected), 0);
  const auto pixels = std::as_bytes(std::span(image.pixels(), image.bulk_used()));
  bytes.append(pixels);
  const auto found = image_pixels(bytes.bytes());
  ASSERT_TRUE(found);
  EXPECT_TRUE(std::equal(found->begin(), found->end(), pixels.begin(), pixels.end()));
  EXPECT_FALSE(image_pixels(bytes.bytes().first(bytes.size() - 1)));

  const ImageHead head = head_of(image, true);
  ImageHead read;
  encode(bytes, head);
  ASSERT_TRUE(decode(bytes.bytes(), read));
  EXPECT_EQ(read, head);
  image.pixels()[15] ^= 1;
  EXPECT_NE(head_of(image, true).pixel_hash, head.pixel_hash);
}

TEST(Image, TimesBeforeTheEpochRoundDown) {
  msg::ImageBuffer buffer(64);
  msg::Image& image = *buffer;
  ASSERT_TRUE(image.format_as(msg::PixelFormat::mono8, 1, 1));
  image.stamp = {-1};
  Buffer bytes;
  encode_image_head(bytes, image, 0, "");
  Cursor from(bytes.bytes().subspan(4));
  EXPECT_EQ(from.number<std::uint32_t>(), 0xFFFFFFFFu);
  EXPECT_EQ(from.number<std::uint32_t>(), 999'999'999u);
}

}  // namespace
}  // namespace sinew::record::messages_test
