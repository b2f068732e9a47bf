#include "images/pixel_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew::images::pixel_rows_test {
namespace {

std::uint8_t rounded(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
}
std::uint8_t luma(int y) { return rounded((y - 16) * 255.0 / 219); }
/// A half, as at both ends of the range, is rounded down.
std::uint8_t chroma(int c) { return rounded(128 + (c - 128) * 255.0 / 224 - 1e-3); }

/// Every value, in a row of this many pairs that ends with its memory.
std::vector<std::uint8_t> row(std::size_t pairs, int first) {
  std::vector<std::uint8_t> bytes(4 * pairs);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(i % 2 == 0 ? 2 * first + i : first + i / 2);
  return bytes;
}

TEST(ImagesPixelRows, LumaAndColourOfEachValueAreThoseOfFullRange) {
  for (const std::size_t pairs : {1u, 15u, 16u, 17u, 320u, 333u}) {
    for (const int first : {0, 64, 128, 200}) {
      const auto in = row(pairs, first), below = row(pairs, first + 5);
      std::vector<std::uint8_t> y(2 * pairs), u(pairs), v(pairs);
      luma_of_yuyv(in.data(), 2 * pairs, y.data());
      for (std::size_t i = 0; i < y.size(); ++i) ASSERT_EQ(y[i], luma(in[2 * i])) << int(in[2 * i]);
      luma_of_yuyv(in.data() + 2, 2 * pairs - 1, y.data());  // from the second pixel
      for (std::size_t i = 0; i + 1 < y.size(); ++i) ASSERT_EQ(y[i], luma(in[2 * i + 2]));
      chroma_of_yuyv(in.data(), pairs, u.data(), v.data());
      for (std::size_t i = 0; i < pairs; ++i) {
        ASSERT_EQ(u[i], chroma(in[4 * i + 1])) << int(in[4 * i + 1]);
        ASSERT_EQ(v[i], chroma(in[4 * i + 3])) << int(in[4 * i + 3]);
      }
      mean_chroma_of_yuyv(in.data(), below.data(), pairs, u.data(), v.data());
      for (std::size_t i = 0; i < pairs; ++i) {
        ASSERT_EQ(u[i], chroma((in[4 * i + 1] + below[4 * i + 1] + 1) / 2));
        ASSERT_EQ(v[i], chroma((in[4 * i + 3] + below[4 * i + 3] + 1) / 2));
      }
    }
  }
}

}  // namespace
}  // namespace sinew::images::pixel_rows_test
