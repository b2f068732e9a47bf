#include "hal/linux/grab/grab_pixels.hpp"

#include <algorithm>
#include <cstring>

namespace sinew::hal {
namespace {

// BT.601 in 1/65536.
std::uint8_t full_luma(int r, int g, int b) {
  return static_cast<std::uint8_t>((19595 * r + 38470 * g + 7471 * b + 32768) >> 16);
}
std::uint8_t limited_luma(int r, int g, int b) {
  return static_cast<std::uint8_t>(16 + ((16829 * r + 33039 * g + 6416 * b + 32768) >> 16));
}
std::uint8_t limited_u(int r, int g, int b) {
  return static_cast<std::uint8_t>(128 + ((-9714 * r - 19070 * g + 28784 * b + 32768) >> 16));
}
std::uint8_t limited_v(int r, int g, int b) {
  return static_cast<std::uint8_t>(128 + ((28784 * r - 24103 * g - 4681 * b + 32768) >> 16));
}

/// Where the channels of a pixel in the shared memory are.
template <bool kRgb>
constexpr int kRedAt = kRgb ? 0 : 2;

/// One row of the picture, as large as the row of the image, in the image's format.
template <bool kRgb>
void put_same_size(const std::uint8_t* in, std::uint32_t width, msg::PixelFormat format, std::uint8_t* out) {
  constexpr int r = kRedAt<kRgb>, b = 2 - r;
  switch (format) {
    case msg::PixelFormat::rgb8:
      for (std::uint32_t x = 0; x < width; ++x, in += 4, out += 3) out[0] = in[r], out[1] = in[1], out[2] = in[b];
      break;
    case msg::PixelFormat::bgr8:
      for (std::uint32_t x = 0; x < width; ++x, in += 4, out += 3) out[0] = in[b], out[1] = in[1], out[2] = in[r];
      break;
    case msg::PixelFormat::mono8:
      for (std::uint32_t x = 0; x < width; ++x, in += 4) out[x] = full_luma(in[r], in[1], in[b]);
      break;
    case msg::PixelFormat::yuyv:
      for (std::uint32_t x = 0; x < width; x += 2, in += 8, out += 4) {
        out[0] = limited_luma(in[r], in[1], in[b]);
        if (x + 1 == width) {  // no pair: an image of odd width has half a pair at its end
          out[1] = limited_u(in[r], in[1], in[b]);
          break;
        }
        out[2] = limited_luma(in[4 + r], in[5], in[4 + b]);
        const int red = (in[r] + in[4 + r] + 1) / 2, green = (in[1] + in[5] + 1) / 2,
                  blue = (in[b] + in[4 + b] + 1) / 2;
        out[1] = limited_u(red, green, blue), out[3] = limited_v(red, green, blue);
      }
      break;
    case msg::PixelFormat::none:
      break;
  }
}

}  // namespace

void GrabPixels::reserve(std::uint32_t width, std::uint32_t height) {
  columns_.resize(std::max<std::size_t>(columns_.size(), width)),
      lines_.resize(std::max<std::size_t>(lines_.size(), height));
  sums_.resize(std::max<std::size_t>(sums_.size(), std::size_t{4} * width));
  row_.resize(std::max<std::size_t>(row_.size(), std::size_t{4} * width));
}

/// Which pixels of the picture each pixel of the image stands for: `spans` divide `from` pixels of the region, whose
/// pixel `offset` is the first of `inside` that there are.
void GrabPixels::spans_of(std::uint32_t from, std::int64_t offset, std::uint32_t inside,
                          std::vector<Span>& spans) noexcept {
  const auto count = static_cast<std::uint64_t>(spans.size());
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto begin = static_cast<std::int64_t>(i * from / count);
    const auto end = std::max(static_cast<std::int64_t>((i + 1) * from / count), begin + 1);
    const std::int64_t first = std::max<std::int64_t>(begin - offset, 0),
                       last = std::min<std::int64_t>(end - offset, inside);
    spans[static_cast<std::size_t>(i)] =
        last > first ? Span{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last - first)} : Span{};
  }
}

void GrabPixels::convert(const GrabPicture& picture, const GrabRegion& region, msg::Image& out) noexcept {
  reserve(out.width, out.height);
  columns_.resize(out.width), lines_.resize(out.height);
  const std::uint32_t width = region.width ? region.width : std::max<std::uint32_t>(picture.window_width, 1);
  const std::uint32_t height = region.height ? region.height : std::max<std::uint32_t>(picture.window_height, 1);
  spans_of(width, std::int64_t{picture.x} - region.x, picture.width, columns_);
  spans_of(height, std::int64_t{picture.y} - region.y, picture.height, lines_);
  if (picture.order == grab::PixelOrder::rgbx)
    rows<true>(picture, out);
  else
    rows<false>(picture, out);
}

template <bool kRgb>
void GrabPixels::rows(const GrabPicture& picture, msg::Image& out) noexcept {
  const bool same_width = picture.width == out.width && columns_.front().first == 0 && columns_.front().count == 1 &&
                          columns_.back().first + 1 == picture.width && columns_.back().count == 1;
  constexpr int r = kRedAt<kRgb>, b = 2 - r;
  for (std::uint32_t y = 0; y < out.height; ++y) {
    const Span line = lines_[y];
    if (same_width && line.count == 1) {
      put_same_size<kRgb>(picture.row(line.first), out.width, out.format, out.row(y));
      continue;
    }
    std::fill(sums_.begin(), sums_.begin() + std::ptrdiff_t{4} * out.width, 0u);
    for (std::uint32_t i = 0; i < line.count; ++i) {
      const std::uint8_t* in = picture.row(line.first + i);
      for (std::uint32_t x = 0; x < out.width; ++x) {
        const Span column = columns_[x];
        const std::uint8_t* at = in + std::size_t{column.first} * 4;
        std::uint32_t* sum = &sums_[std::size_t{4} * x];
        for (std::uint32_t k = 0; k < column.count; ++k, at += 4) sum[0] += at[r], sum[1] += at[1], sum[2] += at[b];
        sum[3] += column.count;
      }
    }
    for (std::uint32_t x = 0; x < out.width; ++x) {
      const std::uint32_t* sum = &sums_[std::size_t{4} * x];
      for (std::size_t c = 0; c < 3; ++c)
        row_[std::size_t{4} * x + c] = static_cast<std::uint8_t>(sum[3] ? (sum[c] + sum[3] / 2) / sum[3] : 0);
    }
    put_same_size<true>(row_.data(), out.width, out.format, out.row(y));
  }
}

}  // namespace sinew::hal
