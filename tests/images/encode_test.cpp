#include "images/encode.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <new>
#include <string>

#include "../rt/counting_new.hpp"
#include "decoders.hpp"

namespace sinew::images::encode_test {
namespace {

using msg::PixelFormat;
using test::decode_lossless;
using test::Decoded;
using test::kFormats;
using test::Picture;

constexpr Kind kLossless[] = {Kind::png, Kind::tiff, Kind::bmp};

/// yuyv is calculated in whole numbers: one beside the rounded double is right.
int tolerance(PixelFormat format) { return format == PixelFormat::yuyv ? 1 : 0; }

Decoded coded(Encoder& encoder, const PixelView& view, Kind kind, const Cut& cut = {}) {
  const auto file = encoder.encode(view, kind, cut);
  if (!file) {
    ADD_FAILURE() << file.error().where;
    return {};
  }
  const auto decoded = decode_lossless(kind, *file);
  EXPECT_TRUE(decoded) << media_type(kind) << ": no decoder takes it";
  return decoded ? *decoded : Decoded{};
}

std::string refusal(const PixelView& view, const Cut& cut = {}) {
  Encoder encoder;
  const auto file = encoder.encode(view, Kind::png, cut);
  if (file) return "";
  EXPECT_EQ(file.error().code, hal::Errc::bad_argument);
  return file.error().where;
}

TEST(ImagesEncode, EveryLosslessKindGivesBackEachPixelOfEachFormat) {
  Encoder encoder;
  for (const PixelFormat format : kFormats)
    for (const auto& [width, height, slack] :
         {std::array{1u, 1u, 0u}, {2u, 1u, 0u}, {37u, 11u, 27u}, {64u, 3u, 0u}, {1280u, 960u, 0u}})
      for (const Kind kind : kLossless) {
        SCOPED_TRACE(testing::Message() << pixel_format_name(format) << ' ' << width << 'x' << height << ' '
                                        << media_type(kind));
        const Picture picture(format, width, height, slack);
        const Decoded image = coded(encoder, picture.view(), kind);
        ASSERT_EQ(image.width, width);
        ASSERT_EQ(image.height, height);
        EXPECT_EQ(image.channels, format == PixelFormat::mono8 && kind != Kind::bmp ? 1u : 3u);
        EXPECT_LE(test::largest_difference(image, [&](auto x, auto y) { return picture.at(x, y); }), tolerance(format));
      }
}

TEST(ImagesEncode, ARegionHasItsPixelsAndEndsAtTheBorder) {
  Encoder encoder;
  for (const PixelFormat format : kFormats)
    for (const Kind kind : kLossless)
      for (const std::uint32_t left : {8u, 13u}) {
        SCOPED_TRACE(testing::Message() << pixel_format_name(format) << ' ' << media_type(kind) << ' ' << left);
        const Picture picture(format, 37, 21, 5);
        const auto from = [&](auto x, auto y) { return picture.at(left + x, 4 + y); };
        const Decoded inside = coded(encoder, picture.view(), kind, {.x = left, .y = 4, .width = 9, .height = 6});
        ASSERT_EQ(inside.width, 9u);
        ASSERT_EQ(inside.height, 6u);
        EXPECT_LE(test::largest_difference(inside, from), tolerance(format));
        const Decoded beyond = coded(encoder, picture.view(), kind, {.x = left, .y = 4, .width = 900});
        ASSERT_EQ(beyond.width, 37 - left);
        ASSERT_EQ(beyond.height, 17u);
        EXPECT_LE(test::largest_difference(beyond, from), tolerance(format));
      }
}

TEST(ImagesEncode, HalfAndQuarterAreTheExactAverages) {
  Encoder encoder;
  for (const PixelFormat format : kFormats)
    for (const std::uint32_t k : {2u, 4u}) {
      SCOPED_TRACE(testing::Message() << pixel_format_name(format) << " 1/" << k);
      const Picture picture(format, 72, 40, 3);
      const Decoded image = coded(encoder, picture.view(), Kind::tiff, {.x = 4, .y = 8, .width = 64, .scale = 1.0 / k});
      ASSERT_EQ(image.width, 64 / k);
      ASSERT_EQ(image.height, 32 / k);
      EXPECT_LE(test::largest_difference(image, [&](auto x, auto y) { return picture.mean(4 + k * x, 8 + k * y, k); }),
                tolerance(format));
    }
}

TEST(ImagesEncode, PartsOfPixelsCountByTheirArea) {
  Picture picture(PixelFormat::mono8, 3, 3);
  picture.bytes() = {0, 90, 180, 30, 60, 90, 200, 100, 50};
  Encoder encoder;
  const Decoded image = coded(encoder, picture.view(), Kind::png, {.scale = 2.0 / 3});
  ASSERT_EQ(image.width, 2u);
  // Each of the four covers 1.5 x 1.5 pixels: 4 parts of its corner, 2 of each side, 1 of the middle.
  EXPECT_EQ(image.pixels, (std::vector<std::uint8_t>{33, 127, 124, 71}));
}

TEST(ImagesEncode, AScaleThatLeavesNothingLeavesOnePixel) {
  Encoder encoder;
  const Picture picture(PixelFormat::rgb8, 5, 5);
  const Decoded image = coded(encoder, picture.view(), Kind::png, {.scale = 1e-9});
  ASSERT_EQ(image.width, 1u);
  ASSERT_EQ(image.height, 1u);
  EXPECT_EQ(image.at(0, 0), picture.mean(0, 0, 5));
}

TEST(ImagesEncode, WhiteStaysWhiteInTheLargestPicture) {
  const std::vector<std::uint8_t> white(kMaxPixels, 255);
  Encoder encoder;
  const Decoded image = coded(encoder, {white, 4096, 4096, 4096, PixelFormat::mono8}, Kind::png, {.scale = 1e-9});
  EXPECT_EQ(image.pixels, (std::vector<std::uint8_t>{255}));
}

TEST(ImagesEncode, AMessageIsEncodedAsItIs) {
  alignas(std::max_align_t) std::byte slot[sizeof(msg::Image) + 6];
  auto* message = new (slot) msg::Image;
  message->set_bulk_capacity(6);
  ASSERT_TRUE(message->format_as(PixelFormat::mono8, 3, 2));
  for (int i = 0; i < 6; ++i) message->pixels()[i] = static_cast<std::uint8_t>(i);
  Encoder encoder;
  EXPECT_EQ(coded(encoder, view(*message), Kind::png).pixels, (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5}));
  message->height = 3;
  EXPECT_EQ(refusal(view(*message)), "picture: fewer bytes than its rows need");
}

TEST(ImagesEncode, WhatCannotBeEncodedIsRefusedWithTheReason) {
  const Picture picture(PixelFormat::rgb8, 20, 11);
  PixelView view = picture.view();
  EXPECT_EQ(refusal(view, {.x = 20}), "region: it begins outside of the picture");
  EXPECT_EQ(refusal(view, {.y = 11}), "region: it begins outside of the picture");
  for (const double scale : {0.0, -1.0, 1.0001, std::nan("")})
    EXPECT_EQ(refusal(view, {.scale = scale}), "scale: above 0, at most 1");
  view.bytes = view.bytes.first(view.bytes.size() - 1);
  EXPECT_EQ(refusal(view), "picture: fewer bytes than its rows need");
  view = picture.view(), view.stride = 59;
  EXPECT_EQ(refusal(view), "picture: its stride is shorter than a row");
  view = picture.view(), view.stride = 0xFFFFFFFF;
  EXPECT_EQ(refusal(view), "picture: fewer bytes than its rows need");
  view = picture.view(), view.format = PixelFormat::none;
  EXPECT_EQ(refusal(view), "picture: it has no pixels");
  view = picture.view(), view.height = 0;
  EXPECT_EQ(refusal(view), "picture: it has no pixels");
  view = picture.view(), view.height = 0xFFFFFFFF;
  EXPECT_EQ(refusal(view), "picture: more than 16384 pixels wide or high, or more than 16777216 pixels");
  EXPECT_EQ(refusal(PixelView{}), "picture: it has no pixels");
}

TEST(ImagesEncode, YuyvOfOddWidthNeedsItsLastPair) {
  Picture picture(PixelFormat::yuyv, 3, 1);
  PixelView view = picture.view();
  EXPECT_EQ(refusal(view), "");
  view.stride = 6;
  EXPECT_EQ(refusal(view), "picture: its stride is shorter than a row");
}

TEST(ImagesEncode, TheSecondPictureOfASizeAllocatesNothing) {
  Encoder encoder;
  for (const PixelFormat format : kFormats)
    for (const Kind kind : {Kind::png, Kind::tiff, Kind::bmp, Kind::jpeg})
      for (const double scale : {1.0, 0.3}) {
        if (!is_built(kind)) continue;
        const Picture picture(format, 133, 77);
        ASSERT_TRUE(encoder.encode(picture.view(), kind, {.scale = scale}));
        const std::uint64_t before = sinew::test::allocations();
        ASSERT_TRUE(encoder.encode(picture.view(), kind, {.scale = scale}));
        EXPECT_EQ(sinew::test::allocations(), before) << pixel_format_name(format) << ' ' << media_type(kind);
      }
}

TEST(ImagesEncode, EndingsAndMediaTypesNameTheKinds) {
  EXPECT_EQ(kind_of("jpg"), Kind::jpeg);
  EXPECT_EQ(kind_of("jpeg"), Kind::jpeg);
  EXPECT_EQ(kind_of("png"), Kind::png);
  EXPECT_EQ(kind_of("tif"), Kind::tiff);
  EXPECT_EQ(kind_of("tiff"), Kind::tiff);
  EXPECT_EQ(kind_of("bmp"), Kind::bmp);
  EXPECT_EQ(kind_of("gif"), std::nullopt);
  EXPECT_EQ(kind_of(""), std::nullopt);
  EXPECT_STREQ(media_type(Kind::jpeg), "image/jpeg");
  EXPECT_STREQ(media_type(Kind::tiff), "image/tiff");
}

}  // namespace
}  // namespace sinew::images::encode_test
