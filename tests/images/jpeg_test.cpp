#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <string>

#include "images/encode.hpp"
#include "pictures.hpp"

namespace sinew::images::jpeg_test {
namespace {

using msg::PixelFormat;
using test::Decoded;
using test::kFormats;
using test::Picture;

struct Read : Decoded {
  int subsampling = -1;
};

Read decode(std::span<const std::byte> file) {
  Read out;
  const auto* bytes = reinterpret_cast<const unsigned char*>(file.data());
  const tjhandle handle = tjInitDecompress();
  int width = 0, height = 0, colours = 0;
  if (tjDecompressHeader3(handle, bytes, file.size(), &width, &height, &out.subsampling, &colours) == 0) {
    out.width = std::uint32_t(width), out.height = std::uint32_t(height), out.channels = 3;
    out.pixels.resize(std::size_t{3} * out.width * out.height);
    // Accurate, and colour not smoothed between pixels: what the file says.
    if (tjDecompress2(handle, bytes, file.size(), out.pixels.data(), width, 0, height, TJPF_RGB,
                      TJFLAG_ACCURATEDCT | TJFLAG_FASTUPSAMPLE | TJFLAG_STOPONWARNING) != 0)
      ADD_FAILURE() << tjGetErrorStr2(handle);
  } else {
    ADD_FAILURE() << tjGetErrorStr2(handle);
  }
  tjDestroy(handle);
  return out;
}

Read coded(const PixelView& view, const Cut& cut = {}, const EncodeOptions& options = {.quality = 95}) {
  Encoder encoder;
  const auto file = encoder.encode(view, Kind::jpeg, cut, options);
  if (file) return decode(*file);
  ADD_FAILURE() << file.error().where;
  return {};
}

TEST(ImagesJpeg, EachFormatAndSizeComesBackNearly) {
  for (const PixelFormat format : kFormats)
    for (const Chroma chroma : {Chroma::yuv420, Chroma::yuv422})
      for (const auto& [width, height, slack] :
           {std::array{1u, 1u, 0u}, {2u, 1u, 0u}, {37u, 11u, 27u}, {64u, 33u, 0u}, {1280u, 960u, 0u}}) {
        SCOPED_TRACE(testing::Message() << pixel_format_name(format) << ' ' << width << 'x' << height << ' '
                                        << int(chroma));
        const Picture picture(format, width, height, slack);
        const Read image = coded(picture.view(), {}, {.quality = 95, .chroma = chroma});
        ASSERT_EQ(image.width, width);
        ASSERT_EQ(image.height, height);
        EXPECT_GT(test::psnr_db(image, [&](auto x, auto y) { return picture.at(x, y); }), 35);
        if (format != PixelFormat::mono8) {
          EXPECT_EQ(image.subsampling, chroma == Chroma::yuv420 ? TJSAMP_420 : TJSAMP_422);
        } else {
          EXPECT_EQ(image.subsampling, TJSAMP_GRAY);
        }
      }
}

TEST(ImagesJpeg, ARegionOfYuyvMayBeginInTheMiddleOfAPair) {
  const Picture picture(PixelFormat::yuyv, 101, 67);
  for (const Chroma chroma : {Chroma::yuv420, Chroma::yuv422})
    for (const std::uint32_t left : {6u, 7u})
      for (const std::uint32_t width : {20u, 21u, 94u}) {
        const std::uint32_t shown = std::min(width, 101 - left);
        const Read image =
            coded(picture.view(), {.x = left, .y = 3, .width = width, .height = 31}, {.quality = 95, .chroma = chroma});
        ASSERT_EQ(image.width, shown);
        ASSERT_EQ(image.height, 31u);
        EXPECT_GT(test::psnr_db(image, [&](auto x, auto y) { return picture.at(left + x, 3 + y); }), 35)
            << left << ' ' << width;
      }
}

TEST(ImagesJpeg, ASmallerPictureIsTheAverage) {
  for (const PixelFormat format : kFormats)
    for (const std::uint32_t k : {2u, 4u}) {
      const Picture picture(format, 160, 120);
      const Read image = coded(picture.view(), {.x = 8, .y = 4, .width = 128, .height = 96, .scale = 1.0 / k});
      ASSERT_EQ(image.width, 128 / k);
      ASSERT_EQ(image.height, 96 / k);
      EXPECT_GT(test::psnr_db(image, [&](auto x, auto y) { return picture.mean(8 + k * x, 4 + k * y, k); }), 34)
          << pixel_format_name(format) << " 1/" << k;
    }
}

TEST(ImagesJpeg, OddSizesScaleToOddSizes) {
  const Picture picture(PixelFormat::yuyv, 61, 45);
  const Read image = coded(picture.view(), {.x = 1, .scale = 1.0 / 4});
  ASSERT_EQ(image.width, 15u);
  ASSERT_EQ(image.height, 11u);
  EXPECT_GT(test::psnr_db(image, [&](auto x, auto y) { return picture.mean(1 + 4 * x, 4 * y, 4); }), 25);
}

TEST(ImagesJpeg, YuyvKeepsItsOwnLumaAndColour) {
  // One colour, which RGB cannot hold: a way through RGB would clamp it.
  Picture picture(PixelFormat::yuyv, 32, 32);
  for (std::size_t i = 0; i < picture.bytes().size(); ++i)
    picture.bytes()[i] = i % 2 == 0 ? 230 : i % 4 == 1 ? 42 : 209;
  Encoder encoder;
  const auto file = encoder.encode(picture.view(), Kind::jpeg, {}, {.quality = 100});
  ASSERT_TRUE(file);
  std::vector<unsigned char> planes(tjBufSizeYUV2(32, 1, 32, TJSAMP_420));
  const tjhandle handle = tjInitDecompress();
  ASSERT_EQ(tjDecompressToYUV2(handle, reinterpret_cast<const unsigned char*>(file->data()), file->size(),
                               planes.data(), 32, 1, 32, TJFLAG_ACCURATEDCT),
            0);
  tjDestroy(handle);
  EXPECT_NEAR(planes[0], 249, 1);
  EXPECT_NEAR(planes[32 * 32], 30, 1);
  EXPECT_NEAR(planes[32 * 32 + 16 * 16], 220, 1);
}

TEST(ImagesJpeg, LowerQualityMakesASmallerFile) {
  Encoder encoder;
  const Picture picture(PixelFormat::yuyv, 320, 240);
  std::size_t before = 0;
  for (const int quality : {1, 30, 80, 100}) {
    const auto file = encoder.encode(picture.view(), Kind::jpeg, {}, {.quality = quality});
    ASSERT_TRUE(file);
    EXPECT_GT(file->size(), before);
    before = file->size();
  }
}

TEST(ImagesJpeg, AQualityOutOfRangeIsRefused) {
  Encoder encoder;
  const Picture picture(PixelFormat::mono8, 8, 8);
  for (const int quality : {0, -1, 101}) {
    const auto file = encoder.encode(picture.view(), Kind::jpeg, {}, {.quality = quality});
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code, hal::Errc::bad_argument);
    EXPECT_STREQ(file.error().where, "quality: 1 to 100");
  }
}

}  // namespace
}  // namespace sinew::images::jpeg_test
