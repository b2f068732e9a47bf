#include "dataset/png_image.hpp"

#include <gtest/gtest.h>

#include "png_writer.hpp"

namespace sinew::dataset::png_image_test {
namespace {

using msg::PixelFormat;
using test::encode_png;

std::vector<std::uint8_t> ramp(std::size_t n) {
  std::vector<std::uint8_t> v(n);
  for (std::size_t i = 0; i < n; ++i) v[i] = static_cast<std::uint8_t>(i * 7 + i / 13);
  return v;
}

TEST(PngImage, GreyAndColourComeBackByteForByte) {
  std::string why;
  DecodedImage image;
  const auto grey = ramp(37 * 11), colour = ramp(37 * 11 * 3);
  ASSERT_TRUE(decode_png(encode_png(grey, 37, 11, 1), image, why)) << why;
  EXPECT_EQ(image.format, PixelFormat::mono8);
  EXPECT_EQ(image.width, 37u);
  EXPECT_EQ(image.height, 11u);
  EXPECT_EQ(image.pixels, grey);
  ASSERT_TRUE(decode_png(encode_png(colour, 37, 11, 3), image, why)) << why;
  EXPECT_EQ(image.format, PixelFormat::rgb8);
  EXPECT_EQ(image.pixels, colour);
  ASSERT_TRUE(decode_png(encode_png(colour, 37, 11, 3, 8, true), image, why)) << why;  // interlaced
  EXPECT_EQ(image.pixels, colour);
}

TEST(PngImage, WhatIsWrittenIsReadBackWithoutThePaddingOfItsRows) {
  std::string why;
  DecodedImage image;
  const auto read = [&](const std::string& file) {
    return decode_png({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, image, why);
  };
  const auto pixels = ramp(64 * 11);
  ASSERT_TRUE(read(dataset::encode_png(PixelFormat::mono8, 37, 11, 64, pixels, why))) << why;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(image.pixels[i], pixels[i / 37 * 64 + i % 37]);
  ASSERT_TRUE(read(dataset::encode_png(PixelFormat::rgb8, 20, 11, 64, pixels, why))) << why;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(image.pixels[i], pixels[i / 60 * 64 + i % 60]);
  const auto rgb = image.pixels;
  ASSERT_TRUE(read(dataset::encode_png(PixelFormat::bgr8, 20, 11, 64, pixels, why))) << why;
  for (std::size_t i = 0; i < rgb.size(); ++i) ASSERT_EQ(image.pixels[i], rgb[i / 3 * 3 + 2 - i % 3]);
}

TEST(PngImage, PairsOfPixelsBecomeColour) {
  const std::vector<std::uint8_t> grey_and_red{16, 128, 235, 128, 81, 90, 0, 240};
  std::string why;
  DecodedImage image;
  const std::string file = dataset::encode_png(PixelFormat::yuyv, 3, 1, 8, grey_and_red, why);
  ASSERT_TRUE(decode_png({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, image, why)) << why;
  const std::vector<std::uint8_t> expected{0, 0, 0, 255, 255, 255, 254, 0, 0};  // of limited range
  EXPECT_EQ(image.pixels, expected);
}

TEST(PngImage, FewerPixelsThanAnImageNeedsAreNotWritten) {
  std::string why;
  EXPECT_EQ(dataset::encode_png(PixelFormat::rgb8, 20, 11, 60, ramp(60 * 11 - 1), why), "");
  EXPECT_EQ(why, "659 bytes of pixels are no image of 20 x 11");
  EXPECT_EQ(dataset::encode_png(PixelFormat::rgb8, 20, 11, 59, ramp(60 * 11), why), "");
  EXPECT_EQ(dataset::encode_png(PixelFormat::yuyv, 3, 1, 6, ramp(6), why), "");
  EXPECT_EQ(dataset::encode_png(PixelFormat::none, 3, 1, 6, ramp(6), why), "");
}

TEST(PngImage, SixteenBitsKeepTheUpperEightAndAlphaIsDropped) {
  std::string why;
  DecodedImage image;
  const auto wide = ramp(20 * 5 * 2), alpha = ramp(20 * 5 * 4);
  ASSERT_TRUE(decode_png(encode_png(wide, 20, 5, 1, 16), image, why)) << why;
  EXPECT_EQ(image.format, PixelFormat::mono8);
  for (std::size_t i = 0; i < 100; ++i) ASSERT_EQ(image.pixels[i], wide[2 * i]);
  ASSERT_TRUE(decode_png(encode_png(alpha, 20, 5, 4), image, why)) << why;
  EXPECT_EQ(image.format, PixelFormat::rgb8);
  for (std::size_t i = 0; i < 100; ++i)
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(image.pixels[3 * i + k], alpha[4 * i + k]);
}

TEST(PngImage, EveryCutIsRefusedWithAReason) {
  const auto file = encode_png(ramp(64 * 48), 64, 48, 1);
  for (std::size_t n = 0; n < file.size(); n += 7) {
    std::string why;
    DecodedImage image;
    EXPECT_FALSE(decode_png(std::span(file).first(n), image, why)) << n;
    EXPECT_FALSE(why.empty());
  }
  std::string why;
  DecodedImage image;
  EXPECT_FALSE(decode_png(std::span(file).first(file.size() - 30), image, why));
  EXPECT_EQ(why, "the file is cut off");
}

TEST(PngImage, DamageIsRefusedOrHarmless) {
  const auto good = encode_png(ramp(64 * 48), 64, 48, 1);
  for (std::size_t at = 8; at < good.size(); ++at) {
    auto bad = good;
    bad[at] ^= 0x55;
    std::string why;
    DecodedImage image;
    const bool taken = decode_png(bad, image, why);
    EXPECT_TRUE(taken || !why.empty());
    if (taken) {
      EXPECT_EQ(image.pixels.size(), std::size_t{image.width} * image.height * bytes_per_pixel(image.format));
    }
  }
}

TEST(PngImage, LargerThanAnImageMessageIsRefused) {
  std::string why;
  DecodedImage image;
  EXPECT_FALSE(decode_png(encode_png(std::vector<std::uint8_t>(1281 * 4), 1281, 4, 1), image, why));
  EXPECT_EQ(why, "1281 x 4 pixels; at most 1280 x 960");
  EXPECT_FALSE(decode_png(std::vector<std::uint8_t>{'J', 'F', 'I', 'F'}, image, why));
  EXPECT_EQ(why, "not a PNG file");
}

}  // namespace
}  // namespace sinew::dataset::png_image_test
