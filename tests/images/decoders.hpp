#pragma once
// Decoders that share no code with the encoder: libpng, and small readers of TIFF and BMP.
#include <png.h>

#include <cstring>
#include <map>
#include <optional>

#include "pictures.hpp"

namespace sinew::images::test {

inline const std::uint8_t* bytes_of(std::span<const std::byte> file) {
  return reinterpret_cast<const std::uint8_t*>(file.data());
}

inline std::optional<Decoded> decode_png(std::span<const std::byte> file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, file.data(), file.size())) return std::nullopt;
  const bool colour = (image.format & PNG_FORMAT_FLAG_COLOR) != 0;
  image.format = colour ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  Decoded out{image.width, image.height, colour ? 3u : 1u, {}};
  out.pixels.resize(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, out.pixels.data(), 0, nullptr)) return std::nullopt;
  return out;
}

inline std::uint32_t little(const std::uint8_t* p, int bytes) {
  std::uint32_t v = 0;
  for (int i = bytes - 1; i >= 0; --i) v = v << 8 | p[i];
  return v;
}

/// Baseline TIFF without compression; empty for anything else. Offsets outside of the file are nothing, too.
inline std::optional<Decoded> decode_tiff(std::span<const std::byte> file) {
  const std::uint8_t* p = bytes_of(file);
  if (file.size() < 8 || std::memcmp(p, "II\x2A\0", 4) != 0) return std::nullopt;
  const std::uint32_t at = little(p + 4, 4);
  if (at % 2 != 0 || at + 2 > file.size()) return std::nullopt;
  std::map<std::uint32_t, std::uint32_t> value;
  std::uint32_t last = 0;
  for (std::uint32_t i = 0; i < little(p + at, 2); ++i) {
    const std::uint8_t* entry = p + at + 2 + 12 * i;
    const std::uint32_t tag = little(entry, 2), type = little(entry + 2, 2), count = little(entry + 4, 4);
    if (tag <= last) return std::nullopt;  // the specification wants them sorted
    last = tag;
    value[tag] = little(entry + 8, type == 3 && count == 1 ? 2 : 4);
  }
  Decoded out{value[256], value[257], value[277], {}};
  if (value[259] != 1 || value[278] != out.height || value[262] != (out.channels == 1 ? 1 : 2)) return std::nullopt;
  if (out.channels == 1 ? value[258] != 8
                        : little(p + value[258], 4) != 0x00080008 || little(p + value[258] + 4, 2) != 8)
    return std::nullopt;
  const std::size_t bytes = std::size_t{out.width} * out.height * out.channels;
  if (value[279] != bytes || value[273] + bytes != file.size()) return std::nullopt;
  out.pixels.assign(p + value[273], p + value[273] + bytes);
  return out;
}

/// BMP of 24 bits, rows from below; empty for anything else.
inline std::optional<Decoded> decode_bmp(std::span<const std::byte> file) {
  const std::uint8_t* p = bytes_of(file);
  if (file.size() < 54 || p[0] != 'B' || p[1] != 'M' || little(p + 2, 4) != file.size()) return std::nullopt;
  Decoded out{little(p + 18, 4), little(p + 22, 4), 3, {}};
  const std::size_t stride = (std::size_t{out.width} * 24 + 31) / 32 * 4;
  if (little(p + 10, 4) != 54 || little(p + 14, 4) != 40 || little(p + 26, 2) != 1 || little(p + 28, 2) != 24 ||
      little(p + 30, 4) != 0 || 54 + stride * out.height != file.size())
    return std::nullopt;
  for (std::uint32_t y = 0; y < out.height; ++y)
    for (std::uint32_t x = 0; x < out.width; ++x) {
      const std::uint8_t* pixel = p + 54 + stride * (out.height - 1 - y) + 3 * std::size_t{x};
      out.pixels.insert(out.pixels.end(), {pixel[2], pixel[1], pixel[0]});
    }
  return out;
}

inline std::optional<Decoded> decode_lossless(Kind kind, std::span<const std::byte> file) {
  if (kind == Kind::png) return decode_png(file);
  return kind == Kind::tiff ? decode_tiff(file) : decode_bmp(file);
}

}  // namespace sinew::images::test
