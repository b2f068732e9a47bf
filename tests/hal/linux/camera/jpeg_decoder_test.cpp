#include "hal/linux/camera/jpeg_decoder.hpp"

#include <gtest/gtest.h>

#include <random>

#include "../rt/counting_new.hpp"
#include "jpeg_fixture.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::hal::jpeg_decoder_test {
namespace {

using msg::PixelFormat;

constexpr std::array kFormats{PixelFormat::mono8, PixelFormat::rgb8, PixelFormat::bgr8};

/// Every pixel is what was encoded, within what JPEG loses. `grey`: the colours were not encoded.
void expect_picture(const msg::Image& image, bool grey) {
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const Rgb c = colour_at(x, y);
      const Ycc ycc = ycc_of(c);
      const std::uint8_t* p = image.row(y) + x * msg::bytes_per_pixel(image.format);
      bool right = false;
      switch (image.format) {
        case PixelFormat::mono8:
          right = close(p[0], ycc.y);
          break;
        case PixelFormat::rgb8:
          right = close(p[0], grey ? ycc.y : c.r) && close(p[1], grey ? ycc.y : c.g) && close(p[2], grey ? ycc.y : c.b);
          break;
        case PixelFormat::bgr8:
          right = close(p[2], grey ? ycc.y : c.r) && close(p[1], grey ? ycc.y : c.g) && close(p[0], grey ? ycc.y : c.b);
          break;
        case PixelFormat::yuyv:
        case PixelFormat::none:
          break;
      }
      ASSERT_TRUE(right) << "at " << x << ", " << y << ": " << int{p[0]} << " " << int{p[1]} << "; wanted luma "
                         << ycc.y << ", cb " << ycc.cb << ", cr " << ycc.cr;
    }
}

TEST(JpegDecoder, EverySubsamplingComesOutInEveryFormatAtEvenAndOddSizes) {
  for (const auto& [width, height] : {std::pair{320u, 240u}, {33u, 17u}, {16u, 16u}})
    for (const PixelFormat format : kFormats) {
      JpegDecoder decoder(format, width, height);
      for (int subsampling = 0; subsampling < TJ_NUMSAMP; ++subsampling) {
        SCOPED_TRACE(testing::Message() << width << "x" << height << " format " << static_cast<int>(format)
                                        << " subsampling " << subsampling);
        msg::ImageBuffer image(format, width, height);
        ASSERT_TRUE(decoder.decode(jpeg_of(width, height, subsampling), *image));
        expect_picture(*image, subsampling == TJSAMP_GRAY);
      }
    }
}

TEST(JpegDecoder, YuyvWouldTakeASecondPassAndIsNotGiven) {
  for (const PixelFormat format : kFormats) EXPECT_TRUE(JpegDecoder::gives(format));
  EXPECT_FALSE(JpegDecoder::gives(PixelFormat::yuyv));
  EXPECT_FALSE(JpegDecoder::gives(PixelFormat::none));
  JpegDecoder decoder(PixelFormat::yuyv, 64, 48);
  msg::ImageBuffer image(PixelFormat::yuyv, 64, 48);
  EXPECT_FALSE(decoder.decode(jpeg_of(64, 48, TJSAMP_422), *image));
}

TEST(JpegDecoder, PictureOfAnotherSizeIsRefused) {
  JpegDecoder decoder(PixelFormat::mono8, 320, 240);
  msg::ImageBuffer image(PixelFormat::mono8, 320, 240), small(PixelFormat::mono8, 16, 16);
  for (const auto& [width, height] : {std::pair{320u, 248u}, {328u, 240u}, {16u, 16u}, {640u, 480u}})
    EXPECT_FALSE(decoder.decode(jpeg_of(width, height, TJSAMP_422), *image)) << width;
  EXPECT_FALSE(decoder.decode(jpeg_of(320, 240, TJSAMP_422), *small)) << "nor an image it was not made for";
  EXPECT_TRUE(decoder.decode(jpeg_of(320, 240, TJSAMP_422), *image)) << "and goes on";
}

TEST(JpegDecoder, PictureThatEndsTooEarlyIsRefusedWhereverItEnds) {
  const auto jpeg = jpeg_of(64, 48, TJSAMP_422);
  for (const PixelFormat format : kFormats) {
    JpegDecoder decoder(format, 64, 48);
    msg::ImageBuffer image(format, 64, 48);
    for (std::size_t n = 0; n + 2 < jpeg.size(); ++n)  // the last two bytes only say that it ends
      ASSERT_FALSE(decoder.decode(std::span(jpeg).first(n), *image)) << n << " of " << jpeg.size();
    EXPECT_TRUE(decoder.decode(jpeg, *image));
  }
}

TEST(JpegDecoder, GarbledPicturesAreRefusedOrDecodedAndNothingElse) {
  const auto good = jpeg_of(33, 17, TJSAMP_420);
  std::mt19937 random(3);
  for (const PixelFormat format : kFormats) {
    JpegDecoder decoder(format, 33, 17);
    std::uint32_t refused = 0;
    for (int round = 0; round < 2000; ++round) {
      auto bad = good;
      for (std::uint32_t flips = 1 + random() % 8; flips > 0; --flips)
        bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
      msg::ImageBuffer image(format, 33, 17);  // of exactly its size: the sanitizer sees a byte beyond
      refused += decoder.decode(bad, *image) ? 0 : 1;
    }
    EXPECT_GT(refused, 500u);
    msg::ImageBuffer image(format, 33, 17);
    ASSERT_TRUE(decoder.decode(good, *image));
    expect_picture(*image, false);
  }
}

TEST(JpegDecoder, NothingOfOursIsAllocatedForAPicture) {
  const auto jpeg = jpeg_of(320, 240, TJSAMP_422);
  for (const PixelFormat format : kFormats) {
    JpegDecoder decoder(format, 320, 240);
    msg::ImageBuffer image(format, 320, 240);
    const std::uint64_t before = test::allocations();
    for (int i = 0; i < 10; ++i) static_cast<void>(decoder.decode(jpeg, *image));
    EXPECT_EQ(test::allocations(), before);
  }
}

}  // namespace
}  // namespace sinew::hal::jpeg_decoder_test
