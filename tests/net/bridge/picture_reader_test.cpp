#include "net/bridge/picture_reader.hpp"

#include <gtest/gtest.h>

#include "images/encode.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::net::picture_reader_test {
namespace {

using msg::PixelFormat;
using Bytes = std::vector<std::uint8_t>;

/// Flat: what JPEG loses of it is at most two steps.
msg::ImageBuffer flat(PixelFormat format, std::uint32_t width, std::uint32_t height) {
  msg::ImageBuffer image(format, width, height);
  for (std::uint32_t i = 0; i < image->bulk_used(); ++i)
    image->pixels()[i] = static_cast<std::uint8_t>(60 + 50 * (i % msg::bytes_per_pixel(format)));
  return image;
}

Bytes file_of(const msg::Image& image, images::Kind kind) {
  images::Encoder encoder;
  const auto file = encoder.encode(images::view(image), kind);
  EXPECT_TRUE(file);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(file->data());
  return {begin, begin + file->size()};
}

TEST(PictureReader, GreyAndColourComeFromBothKindsOfFiles) {
  PictureReader reader;
  for (const auto kind : {images::Kind::jpeg, images::Kind::png})
    for (const auto format : {PixelFormat::mono8, PixelFormat::rgb8, PixelFormat::mono8}) {
      if (!images::is_built(kind)) continue;
      const msg::ImageBuffer sent = flat(format, 8, 6);
      msg::ImageBuffer got(8 * 6 * 3);
      ASSERT_STREQ(reader.read(file_of(*sent, kind), *got), nullptr);
      EXPECT_EQ(got->format, format);
      ASSERT_EQ(got->width * 100 + got->height, 806U);
      for (std::uint32_t i = 0; i < got->bulk_used(); ++i)
        ASSERT_NEAR(got->pixels()[i], sent->pixels()[i], kind == images::Kind::png ? 0 : 2);
    }
}

TEST(PictureReader, AnotherSizeIsReadByTheSameReader) {
  PictureReader reader;
  msg::ImageBuffer got(64 * 64 * 3);
  for (const std::uint32_t width : {8U, 64U, 16U}) {
    ASSERT_STREQ(reader.read(file_of(*flat(PixelFormat::rgb8, width, 8), images::Kind::png), *got), nullptr);
    EXPECT_EQ(got->width, width);
    if (!images::is_built(images::Kind::jpeg)) continue;
    ASSERT_STREQ(reader.read(file_of(*flat(PixelFormat::rgb8, width, 8), images::Kind::jpeg), *got), nullptr);
    EXPECT_EQ(got->width, width);
  }
}

TEST(PictureReader, WhatIsNoPictureIsRefusedWithTheReason) {
  PictureReader reader;
  msg::ImageBuffer got(8 * 6 * 3);
  Bytes png = file_of(*flat(PixelFormat::rgb8, 8, 6), images::Kind::png);
  EXPECT_STREQ(reader.read({}, *got), "a file that is neither JPEG nor PNG");
  EXPECT_STREQ(reader.read(Bytes{'G', 'I', 'F', '8'}, *got), "a file that is neither JPEG nor PNG");
  png.resize(png.size() / 2);
  EXPECT_STREQ(reader.read(png, *got), "a PNG file that is damaged, or of more than 1280 x 960 pixels");
  const Bytes large = file_of(*flat(PixelFormat::rgb8, 9, 6), images::Kind::png);
  EXPECT_STREQ(reader.read(large, *got), "an image of no size, or larger than its topic takes");
  if (!images::is_built(images::Kind::jpeg)) return;
  const Bytes whole = file_of(*flat(PixelFormat::rgb8, 8, 6), images::Kind::jpeg);
  EXPECT_STREQ(reader.read(std::span(whole).first(20), *got), "a JPEG file that is damaged");
  EXPECT_STREQ(reader.read(std::span(whole).first(whole.size() - 30), *got), "a JPEG file that is damaged");
  EXPECT_STREQ(reader.read(whole, *got), nullptr) << "after damaged ones";
}

}  // namespace
}  // namespace sinew::net::picture_reader_test
