#include "hal/linux/grab/grab_pixels.hpp"

#include <gtest/gtest.h>

#include "msg/image_buffer.hpp"

namespace sinew::hal::grab_pixels_test {
namespace {

using msg::PixelFormat;

/// A picture of this size whose pixel at x, y (from the top) is r = x, g = y, b = 7.
struct Drawn {
  Drawn(std::uint32_t width, std::uint32_t height, grab::PixelOrder order, bool bottom_up)
      : bytes(std::size_t{width} * height * 4) {
    p.width = p.window_width = width, p.height = p.window_height = height, p.stride = width * 4;
    p.order = order, p.bottom_up = bottom_up, p.pixels = bytes.data();
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x) {
        std::uint8_t* at = &bytes[(std::size_t{bottom_up ? height - 1 - y : y} * width + x) * 4];
        const std::uint8_t r = static_cast<std::uint8_t>(x), b = 7;
        at[0] = order == grab::PixelOrder::rgbx ? r : b, at[1] = static_cast<std::uint8_t>(y);
        at[2] = order == grab::PixelOrder::rgbx ? b : r;
      }
  }
  std::vector<std::uint8_t> bytes;
  GrabPicture p;
};

msg::ImageBuffer converted(const GrabPicture& p, const GrabRegion& region, PixelFormat format, std::uint32_t width,
                           std::uint32_t height) {
  msg::ImageBuffer image(format, width, height);
  GrabPixels pixels;
  pixels.convert(p, region, *image);
  return image;
}

TEST(GrabPixels, BothOrdersAndBothDirectionsGiveTheSameImage) {
  for (const auto order : {grab::PixelOrder::rgbx, grab::PixelOrder::bgrx})
    for (const bool bottom_up : {false, true}) {
      const Drawn drawn(64, 48, order, bottom_up);
      const auto rgb = converted(drawn.p, {}, PixelFormat::rgb8, 64, 48);
      const auto bgr = converted(drawn.p, {}, PixelFormat::bgr8, 64, 48);
      for (const std::uint32_t y : {0u, 1u, 47u})
        for (const std::uint32_t x : {0u, 5u, 63u}) {
          EXPECT_EQ(rgb->row(y)[3 * x], x);
          EXPECT_EQ(rgb->row(y)[3 * x + 1], y);
          EXPECT_EQ(rgb->row(y)[3 * x + 2], 7);
          EXPECT_EQ(bgr->row(y)[3 * x + 2], x);
          EXPECT_EQ(bgr->row(y)[3 * x], 7);
        }
    }
}

TEST(GrabPixels, ASmallerImageHasTheMeanOfEachArea) {
  const Drawn drawn(64, 48, grab::PixelOrder::bgrx, true);
  const auto half = converted(drawn.p, {}, PixelFormat::rgb8, 32, 24);
  EXPECT_EQ(half->row(3)[3 * 5], 11);     // of columns 10 and 11, rounded up
  EXPECT_EQ(half->row(3)[3 * 5 + 1], 7);  // of rows 6 and 7
  const auto odd = converted(drawn.p, {}, PixelFormat::rgb8, 20, 16);
  EXPECT_NEAR(odd->row(8)[3 * 10], 33, 1);
  EXPECT_NEAR(odd->row(8)[3 * 10 + 1], 25, 1);
}

TEST(GrabPixels, ALargerImageRepeatsPixels) {
  const Drawn drawn(32, 32, grab::PixelOrder::rgbx, false);
  const auto twice = converted(drawn.p, {}, PixelFormat::rgb8, 64, 64);
  EXPECT_EQ(twice->row(10)[3 * 21], 10);
  EXPECT_EQ(twice->row(10)[3 * 21 + 1], 5);
}

TEST(GrabPixels, WhatIsOutsideOfTheWindowIsBlack) {
  Drawn drawn(32, 32, grab::PixelOrder::rgbx, false);  // of a window of 32x32, of which -16, -16, 64, 64 was asked for
  const auto image = converted(drawn.p, {-16, -16, 64, 64}, PixelFormat::rgb8, 64, 64);
  EXPECT_EQ(image->row(15)[3 * 30 + 2], 0);
  EXPECT_EQ(image->row(16)[3 * 16 + 2], 7);
  EXPECT_EQ(image->row(47)[3 * 47], 31);
  EXPECT_EQ(image->row(47)[3 * 48 + 2], 0);
}

TEST(GrabPixels, GreyAndYuyvAreThoseOfBt601) {
  Drawn drawn(16, 16, grab::PixelOrder::bgrx, false);
  for (std::size_t i = 0; i < drawn.bytes.size(); i += 4)
    drawn.bytes[i] = 0, drawn.bytes[i + 1] = 0, drawn.bytes[i + 2] = 255;  // red
  const auto grey = converted(drawn.p, {}, PixelFormat::mono8, 16, 16);
  EXPECT_NEAR(grey->row(3)[3], 76, 1);
  const auto yuyv = converted(drawn.p, {}, PixelFormat::yuyv, 16, 16);
  EXPECT_NEAR(yuyv->row(3)[0], 81, 1);
  EXPECT_NEAR(yuyv->row(3)[1], 90, 1);
  EXPECT_NEAR(yuyv->row(3)[2], 81, 1);
  EXPECT_NEAR(yuyv->row(3)[3], 240, 1);
  const auto scaled = converted(drawn.p, {}, PixelFormat::yuyv, 32, 8);
  EXPECT_NEAR(scaled->row(3)[3], 240, 1);
}

TEST(GrabPicture, AnAnswerThatLiesIsLost) {
  grab::Answer a{};
  a.width = 640, a.height = 480, a.stride = 2560;
  EXPECT_EQ(checked_picture(a, 0).status, grab::AnswerStatus::ok);
  const auto refused = [&](auto change) {
    grab::Answer lie = a;
    change(lie);
    return checked_picture(lie, 0).status != grab::AnswerStatus::ok;
  };
  EXPECT_TRUE(refused([](grab::Answer& x) { x.stride = 2559; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.height = 0; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.height = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.stride = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.width = 0x40000001; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.x = -1; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.order = 2; }));
  EXPECT_TRUE(refused([](grab::Answer& x) { x.status = 77; }));
}

}  // namespace
}  // namespace sinew::hal::grab_pixels_test
