#include "wire/text/usarsim_images.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace sinew::wire::usarsim_images_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Head = std::array<std::uint8_t, kUsarImageHead>;

TEST(UsarsimImages, AsksForAllOrForAPart) {
  std::array<std::uint8_t, kUsarImageRequest> out{};
  ASSERT_EQ(write_usarsim_image_request({}, out), 2u);
  EXPECT_EQ(Bytes(out.begin(), out.begin() + 2), (Bytes{'O', 'K'}));
  ASSERT_EQ(write_usarsim_image_request({1, 2, 320, 0x01020304}, out), 17u);
  EXPECT_EQ(Bytes(out.begin(), out.end()), (Bytes{'U', 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 1, 0x40, 1, 2, 3, 4}));
}

TEST(UsarsimImages, HeadsOfPicturesAndOfNone) {
  UsarImageHead head;
  EXPECT_EQ(parse_usarsim_image_head(Head{0, 0, 3, 0x84, 4}, head), UsarImageError::none);
  EXPECT_FALSE(head.jpeg);
  EXPECT_EQ(head.size, 230'404u);
  for (std::uint8_t quality = 1; quality <= 5; ++quality) {
    EXPECT_EQ(parse_usarsim_image_head(Head{quality, 0, 0, 0, 9}, head), UsarImageError::none);
    EXPECT_TRUE(head.jpeg);
  }
  EXPECT_EQ(parse_usarsim_image_head(Head{6, 0, 0, 0, 9}, head), UsarImageError::type);
  EXPECT_EQ(parse_usarsim_image_head(Head{'H', 'T', 'T', 'P', '/'}, head), UsarImageError::type);
  EXPECT_EQ(parse_usarsim_image_head(Head{0, 0, 0, 0, 0}, head), UsarImageError::size);
  EXPECT_EQ(parse_usarsim_image_head(Head{0, 0xFF, 0, 0, 0}, head), UsarImageError::size);
}

TEST(UsarsimImages, RawRowsArePaddedToFourBytesOrNot) {
  UsarRawImage raw;
  Bytes padded{0, 3, 0, 2};
  for (int i = 0; i < 24; ++i) padded.push_back(static_cast<std::uint8_t>(i));
  ASSERT_EQ(parse_usarsim_raw_image(padded, raw), UsarImageError::none);
  EXPECT_EQ(raw.width, 3u);
  EXPECT_EQ(raw.height, 2u);
  EXPECT_EQ(raw.stride, 12u);
  EXPECT_EQ(raw.row(1)[0], 12);
  const Bytes tight(padded.begin(), padded.begin() + 4 + 18);
  ASSERT_EQ(parse_usarsim_raw_image(tight, raw), UsarImageError::none);
  EXPECT_EQ(raw.stride, 9u);
  EXPECT_EQ(raw.row(1)[0], 9);
}

TEST(UsarsimImages, RawBytesThatDoNotFitTheirShapeAreRefused) {
  UsarRawImage raw;
  EXPECT_EQ(parse_usarsim_raw_image({}, raw), UsarImageError::shape);
  EXPECT_EQ(parse_usarsim_raw_image(Bytes{0, 3, 0}, raw), UsarImageError::shape);
  EXPECT_EQ(parse_usarsim_raw_image(Bytes{0, 0, 0, 2}, raw), UsarImageError::shape);
  EXPECT_EQ(parse_usarsim_raw_image(Bytes{0, 3, 0, 0}, raw), UsarImageError::shape);
  EXPECT_EQ(parse_usarsim_raw_image(Bytes(4 + 23, 1), raw), UsarImageError::shape);
  Bytes long_one{0, 3, 0, 2};
  long_one.resize(4 + 25);
  EXPECT_EQ(parse_usarsim_raw_image(long_one, raw), UsarImageError::shape);
}

}  // namespace
}  // namespace sinew::wire::usarsim_images_test
