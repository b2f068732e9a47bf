#include <libdeflate.h>

#include <cstring>

#include "images/file_writers.hpp"

namespace sinew::images {
namespace {

constexpr std::uint8_t kSub = 1;  // the filter of each row

/// Length, name, data that is already in place, and the checksum. Returns the end.
std::uint8_t* close_chunk(std::uint8_t* chunk, const char* name, std::size_t size) {
  Bytes(chunk).big32(static_cast<std::uint32_t>(size));
  std::memcpy(chunk + 4, name, 4);
  Bytes end(chunk + 8 + size);
  end.big32(libdeflate_crc32(0, chunk + 4, 4 + size));
  return end.at();
}

}  // namespace

PngWriter::~PngWriter() { libdeflate_free_compressor(static_cast<libdeflate_compressor*>(compressor_)); }

// Source: PNG specification (ISO/IEC 15948), sections 5, 9.2, 11.2.
File PngWriter::write(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out) {
  if (!compressor_) compressor_ = libdeflate_alloc_compressor(1);
  auto* const compressor = static_cast<libdeflate_compressor*>(compressor_);
  const std::size_t row_bytes = rows.row_bytes(), plain = (1 + row_bytes) * area.out_height;
  std::uint8_t *const filtered = filtered_.at_least(plain), *const row = row_.at_least(row_bytes);
  if (!compressor || !filtered || !row) return no_memory();
  for (std::uint32_t y = 0; y < area.out_height; ++y) {
    std::uint8_t* const to = filtered + y * (1 + row_bytes);
    to[0] = kSub;
    subtract_left(rows.next(row), row_bytes, rows.channels(), to + 1);
  }

  constexpr std::size_t kBefore = 8 + 25 + 8, kBehind = 4 + 12;  // signature, IHDR, head of IDAT; its checksum, IEND
  const std::size_t bound = libdeflate_zlib_compress_bound(compressor, plain);
  std::uint8_t* const file = out.at_least(kBefore + bound + kBehind);
  if (!file) return no_memory();
  Bytes to(file);
  to.put({0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'});
  std::uint8_t* const head = to.at();
  Bytes shape(head + 8);
  shape.big32(area.out_width), shape.big32(area.out_height);
  shape.put({8, rows.channels() == 1 ? 0 : 2, 0, 0, 0});  // bits, grey or RGB, deflate, filters, not interlaced
  std::uint8_t* const data = close_chunk(head, "IHDR", 13);
  const std::size_t packed = libdeflate_zlib_compress(compressor, filtered, plain, data + 8, bound);
  if (packed == 0) return hal::Error{hal::Errc::io, "png: libdeflate could not compress it", 0};
  const std::uint8_t* const end = close_chunk(close_chunk(data, "IDAT", packed), "IEND", 0);
  return std::as_bytes(std::span<const std::uint8_t>(file, end));
}

}  // namespace sinew::images
