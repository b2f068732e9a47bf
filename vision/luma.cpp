#include "vision/luma.hpp"

#include <cstring>

namespace sinew::vision {
namespace {

using BinRest = void (*)(const ImageView& image, std::uint32_t y, std::uint32_t begin, std::uint32_t width,
                         std::uint8_t* out);

/// `kStep` bytes from one grey value to the next: 1 for mono8, 2 for yuyv. Both numbers are known to the compiler,
/// which makes vector code of the inner loops: four times as fast.
template <std::uint32_t kStep, std::uint32_t kBin>
void bin_rest(const ImageView& image, std::uint32_t y, std::uint32_t begin, std::uint32_t width, std::uint8_t* out) {
  const std::uint8_t* rows[kBin];
  for (std::uint32_t i = 0; i < kBin; ++i) rows[i] = image.row(y * kBin + i);
  constexpr std::uint32_t kBlock = 32;  // of the result
  for (; begin < width; begin += kBlock) {
    const std::uint32_t count = width - begin < kBlock ? width - begin : kBlock;
    std::uint16_t columns[kBlock * kBin] = {};
    const std::size_t first = std::size_t{begin} * kBin * kStep;
    for (std::uint32_t x = 0; x < count * kBin; ++x) columns[x] = rows[0][first + std::size_t{x} * kStep];
    for (std::uint32_t i = 1; i < kBin; ++i)
      for (std::uint32_t x = 0; x < count * kBin; ++x)
        columns[x] = static_cast<std::uint16_t>(columns[x] + rows[i][first + std::size_t{x} * kStep]);
    for (std::uint32_t x = 0; x < count; ++x) {
      std::uint32_t sum = kBin * kBin / 2;
      for (std::uint32_t k = 0; k < kBin; ++k) sum += columns[x * kBin + k];
      out[begin + x] = static_cast<std::uint8_t>(sum / (kBin * kBin));
    }
  }
}

template <std::uint32_t kStep>
BinRest bin_rest_of(std::uint32_t bin) {
  switch (bin) {
    case 1:
      return bin_rest<kStep, 1>;
    case 2:
      return bin_rest<kStep, 2>;
    case 4:
      return bin_rest<kStep, 4>;
    case 8:
      return bin_rest<kStep, 8>;
    default:
      return nullptr;
  }
}

}  // namespace

bool Luma::take(const ImageView& image, std::uint32_t bin, Simd simd) {
  clear();
  using msg::PixelFormat;
  if (!image || (image.format != PixelFormat::mono8 && image.format != PixelFormat::yuyv)) return false;
  const bool mono = image.format == PixelFormat::mono8;
  const BinRest rest = mono ? bin_rest_of<1>(bin) : bin_rest_of<2>(bin);
  if (rest == nullptr) return false;
  detail::BinColumns vectors = nullptr;
#ifdef SINEW_VISION_AVX2
  if (simd == Simd::avx2) vectors = detail::bin_columns_avx2(!mono, bin);
#else
  static_cast<void>(simd);
#endif
  const std::uint32_t width = image.width / bin, height = image.height / bin;
  if (width == 0 || height == 0 || std::size_t{width} * height > pixels_.size()) return false;
  const std::uint32_t done = vectors != nullptr ? vectors(image, width, height, pixels_.data()) : 0;
  for (std::uint32_t y = 0; y < height && done < width; ++y) {
    std::uint8_t* out = pixels_.data() + std::size_t{y} * width;
    if (mono && bin == 1)
      std::memcpy(out, image.row(y), width);
    else
      rest(image, y, done, width, out);
  }
  width_ = width, height_ = height;
  return true;
}

}  // namespace sinew::vision
