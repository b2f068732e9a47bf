// The kinds without compression: TIFF and BMP.
#include <cstring>

#include "images/file_writers.hpp"

namespace sinew::images {
namespace {

void copy_next_row(RowSource& rows, std::uint8_t* to) {
  const std::uint8_t* row = rows.next(to);
  if (row != to) std::memcpy(to, row, rows.row_bytes());
}

enum Tag : std::uint16_t { kShort = 3, kLong = 4, kRational = 5 };

}  // namespace

// Source: TIFF 6.0 (Adobe, 1992), sections 2, 4 and 6.
File write_tiff(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out) {
  constexpr std::uint32_t kEntries = 13, kDirectoryAt = 8, kBehind = kDirectoryAt + 2 + 12 * kEntries + 4;
  constexpr std::uint32_t kBitsAt = kBehind, kResolutionAt = kBitsAt + 8, kPixelsAt = kResolutionAt + 8;
  const std::uint32_t channels = rows.channels();
  const std::size_t pixels = rows.row_bytes() * area.out_height, size = kPixelsAt + pixels;
  std::uint8_t* const file = out.at_least(size);
  if (!file) return no_memory();
  Bytes to(file);
  to.put({'I', 'I', 42, 0}), to.little32(kDirectoryAt);
  to.little16(kEntries);
  const auto entry = [&](std::uint32_t tag, Tag type, std::uint32_t count, std::uint32_t value) {
    to.little16(tag), to.little16(type), to.little32(count), to.little32(value);  // a SHORT is the lower half
  };
  entry(256, kLong, 1, area.out_width);
  entry(257, kLong, 1, area.out_height);
  entry(258, kShort, channels, channels == 1 ? 8 : kBitsAt);  // BitsPerSample
  entry(259, kShort, 1, 1);                                   // Compression: none
  entry(262, kShort, 1, channels == 1 ? 1 : 2);               // PhotometricInterpretation: black is zero, RGB
  entry(273, kLong, 1, kPixelsAt);                            // StripOffsets
  entry(277, kShort, 1, channels);                            // SamplesPerPixel
  entry(278, kLong, 1, area.out_height);                      // RowsPerStrip
  entry(279, kLong, 1, static_cast<std::uint32_t>(pixels));   // StripByteCounts
  entry(282, kRational, 1, kResolutionAt);                    // XResolution
  entry(283, kRational, 1, kResolutionAt);                    // YResolution
  entry(284, kShort, 1, 1);                                   // PlanarConfiguration: channels beside each other
  entry(296, kShort, 1, 1);                                   // ResolutionUnit: none, square pixels
  to.little32(0);                                             // no further picture
  for (int i = 0; i < 4; ++i) to.little16(8);                 // the three of BitsPerSample, and one to fill up
  to.little32(1), to.little32(1);
  for (std::uint32_t y = 0; y < area.out_height; ++y) copy_next_row(rows, to.at() + y * rows.row_bytes());
  return std::as_bytes(std::span<const std::uint8_t>(file, size));
}

// Source: Microsoft, "Bitmap Storage" (BITMAPFILEHEADER, BITMAPINFOHEADER).
File write_bmp(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out) {
  constexpr std::uint32_t kInfo = 40, kPixelsAt = 14 + kInfo;
  const std::size_t used = rows.row_bytes(), stride = (used + 3) / 4 * 4, pixels = stride * area.out_height;
  std::uint8_t* const file = out.at_least(kPixelsAt + pixels);
  if (!file) return no_memory();
  Bytes to(file);
  to.put({'B', 'M'}), to.little32(static_cast<std::uint32_t>(kPixelsAt + pixels)), to.little32(0);
  to.little32(kPixelsAt);
  to.little32(kInfo), to.little32(area.out_width), to.little32(area.out_height);
  to.little16(1), to.little16(24);                                  // planes, bits
  to.little32(0), to.little32(static_cast<std::uint32_t>(pixels));  // compression: none
  to.little32(0), to.little32(0), to.little32(0), to.little32(0);   // resolution unknown, no palette
  for (std::uint32_t y = 0; y < area.out_height; ++y) {
    std::uint8_t* const row = to.at() + (area.out_height - 1 - y) * stride;
    copy_next_row(rows, row);
    std::memset(row + used, 0, stride - used);
  }
  return std::as_bytes(std::span<const std::uint8_t>(file, kPixelsAt + pixels));
}

}  // namespace sinew::images
