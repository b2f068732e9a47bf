#pragma once
#include <span>

#include "images/area.hpp"
#include "images/row_source.hpp"

/// One function or class for each kind of file; encoder.cpp calls them with checked arguments.
namespace sinew::images {

using File = hal::Result<std::span<const std::byte>>;

inline hal::Error no_memory() { return {hal::Errc::out_of_memory, "picture: no memory for it", 0}; }

/// Bytes of a file one after the other.
class Bytes {
 public:
  explicit Bytes(std::uint8_t* to) : at_(to) {}
  void put(std::initializer_list<int> bytes) {
    for (const int b : bytes) *at_++ = static_cast<std::uint8_t>(b);
  }
  void little16(std::uint32_t v) { put({int(v & 255), int(v >> 8 & 255)}); }
  void little32(std::uint32_t v) { little16(v & 0xFFFF), little16(v >> 16); }
  void big32(std::uint32_t v) { put({int(v >> 24), int(v >> 16 & 255), int(v >> 8 & 255), int(v & 255)}); }
  std::uint8_t* at() const { return at_; }

 private:
  std::uint8_t* at_;
};

/// Uncompressed, one strip, baseline TIFF 6.0, little endian.
File write_tiff(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out);

/// 24 bits, rows from below to above, with the header of 40 bytes (BITMAPINFOHEADER).
File write_bmp(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out);

/// PNG with the filter Sub and libdeflate's fastest level: see docs/images.md.
class PngWriter {
 public:
  PngWriter() = default;
  ~PngWriter();
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  File write(RowSource& rows, const Area& area, Buffer<std::uint8_t>& out);

 private:
  void* compressor_ = nullptr;
  Buffer<std::uint8_t> filtered_, row_;
};

class JpegWriter {
 public:
  static bool built();
  JpegWriter() = default;
  ~JpegWriter();
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  File write(const PixelView& view, RowSource& rows, const Area& area, const EncodeOptions& options,
             Buffer<std::uint8_t>& out);

 private:
  File of_rows(const PixelView& view, RowSource& rows, const Area& area, const EncodeOptions& options,
               Buffer<std::uint8_t>& out);
  File of_yuyv(const PixelView& view, const Area& area, const EncodeOptions& options, Buffer<std::uint8_t>& out);

  void* compressor_ = nullptr;
  BoxFilter filter_;
  Buffer<std::uint8_t> planes_, scaled_;
};

}  // namespace sinew::images
