#include <gtest/gtest.h>

#include "msg/image_buffer.hpp"

namespace {

using namespace sinew::msg;

TEST(Image, FormatIsRefusedWhereRowsDoNotFitAndNothingChanges) {
  ImageBuffer buffer(320 * 240);
  ASSERT_TRUE(buffer->format_as(PixelFormat::mono8, 320, 240));
  EXPECT_FALSE(buffer->format_as(PixelFormat::mono8, 320, 241));
  EXPECT_FALSE(buffer->format_as(PixelFormat::rgb8, 320, 240));
  EXPECT_FALSE(buffer->format_as(PixelFormat::none, 1, 1));
  EXPECT_FALSE(buffer->format_as(PixelFormat::mono8, 0, 1));
  EXPECT_FALSE(buffer->format_as(PixelFormat::mono8, kMaxImageWidth + 1, 1));
  EXPECT_EQ(buffer->format, PixelFormat::mono8);
  EXPECT_EQ(buffer->height, 240U);
  EXPECT_EQ(buffer->bulk_used(), 320U * 240U);
}

TEST(Image, EveryFormatThatHasPixelsHasANameAndIsFoundByIt) {
  std::uint32_t next = 1;  // of the enumeration: none is left out
  for (const auto& [name, format] : kPixelFormats) {
    EXPECT_EQ(static_cast<std::uint32_t>(format), next++);
    EXPECT_GT(bytes_per_pixel(format), 0U);
    EXPECT_EQ(pixel_format_name(format), name);
    EXPECT_EQ(pixel_format_of(name), format);
  }
  EXPECT_EQ(bytes_per_pixel(static_cast<PixelFormat>(next)), 0U);
  EXPECT_STREQ(pixel_format_name(PixelFormat::none), "none");
  EXPECT_EQ(pixel_format_of("yuv"), PixelFormat::none);
}

TEST(Image, UsedBytesNeverExceedTheCapacityWhateverTheFieldsSay) {
  ImageBuffer buffer(100);
  buffer->stride = 0xffffffff, buffer->height = 0xffffffff;
  EXPECT_EQ(buffer->bulk_used(), 100U);
}

TEST(Image, PixelsFollowTheHeader) {
  ImageBuffer buffer(PixelFormat::bgr8, 4, 3);
  EXPECT_EQ(buffer->stride, 12U);
  EXPECT_EQ(reinterpret_cast<std::uint8_t*>(&*buffer) + sizeof(Image), buffer->pixels());
  EXPECT_EQ(buffer->row(2), buffer->pixels() + 24);
}

TEST(ImageBuffer, OfAFormatIsJustLargeEnoughAndEmptyForImpossibleOnes) {
  EXPECT_EQ(ImageBuffer(PixelFormat::rgb8, 640, 480)->capacity_bytes, 921600U);
  EXPECT_EQ(ImageBuffer(PixelFormat::rgb8, 70000, 70000)->format, PixelFormat::none);
}

TEST(ImageBuffer, CopiesKeepTheirOwnCapacityAndRefuseWhatDoesNotFit) {
  ImageBuffer from(PixelFormat::mono8, 10, 10), to(200), small(99);
  from->frame_number = 7;
  from->row(9)[9] = 42;
  ASSERT_TRUE(to.assign(*from));
  EXPECT_EQ(to->capacity_bytes, 200U);
  EXPECT_EQ(to->frame_number, 7U);
  EXPECT_EQ(to->row(9)[9], 42);
  EXPECT_FALSE(small.assign(*from));
  EXPECT_EQ(small->format, PixelFormat::none);
}

TEST(ImageBuffer, MovesWithItsPixels) {
  ImageBuffer a(PixelFormat::mono8, 2, 2);
  a->pixels()[3] = 9;
  const ImageBuffer b = std::move(a);
  EXPECT_EQ(b->pixels()[3], 9);
}

}  // namespace
