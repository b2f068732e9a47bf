#pragma once
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include "msg/describe.hpp"

namespace sinew::msg {

enum class PixelFormat : std::uint32_t { none = 0, mono8 = 1, rgb8 = 2, bgr8 = 3, yuyv = 4 };

/// Each format that has pixels, by the name that robot files and messages give it.
inline constexpr std::pair<std::string_view, PixelFormat> kPixelFormats[] = {{"mono8", PixelFormat::mono8},
                                                                             {"rgb8", PixelFormat::rgb8},
                                                                             {"bgr8", PixelFormat::bgr8},
                                                                             {"yuyv", PixelFormat::yuyv}};

inline constexpr ValueName kPixelFormatNames[] = {{"none", PixelFormat::none},
                                                  {kPixelFormats[0].first, kPixelFormats[0].second},
                                                  {kPixelFormats[1].first, kPixelFormats[1].second},
                                                  {kPixelFormats[2].first, kPixelFormats[2].second},
                                                  {kPixelFormats[3].first, kPixelFormats[3].second}};
static_assert(std::size(kPixelFormats) == 4, "and one more line above");

constexpr const char* pixel_format_name(PixelFormat f) {
  for (const auto& [name, format] : kPixelFormats)
    if (format == f) return name.data();
  return "none";
}

/// `none` for a name that no format has.
constexpr PixelFormat pixel_format_of(std::string_view name) {
  for (const auto& [known, format] : kPixelFormats)
    if (known == name) return format;
  return PixelFormat::none;
}

constexpr std::uint32_t bytes_per_pixel(PixelFormat f) {
  switch (f) {
    case PixelFormat::none:
      return 0;
    case PixelFormat::mono8:
      return 1;
    case PixelFormat::yuyv:
      return 2;
    case PixelFormat::rgb8:
    case PixelFormat::bgr8:
      return 3;
  }
  return 0;
}

inline constexpr std::uint32_t kMaxImageWidth = 1280, kMaxImageHeight = 960;

/// A camera image: this header and, directly behind it in the same slot, the pixel rows.
/// Shape:   height x width, row-major, top-left first, `stride` bytes from row to row (>= width * bytes per pixel).
/// Owner:   the slot; an Image cannot be copied (its pixels would stay behind), use ImageBuffer outside of slots.
struct Image {
  Time stamp;  // mid-point of the exposure
  std::int64_t exposure_ns = 0;
  std::uint32_t frame_number = 0;  // counted by the camera; a step of more than one is a lost frame
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t stride = 0;
  PixelFormat format = PixelFormat::none;
  std::uint32_t capacity_bytes = 0;  // room behind the header; set by the owner of the slot, kept by format_as()

  Image() = default;
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;

  /// Describes rows without padding. False, and nothing changed, when they would not fit or exceed 1280x960.
  [[nodiscard]] bool format_as(PixelFormat f, std::uint32_t width_px, std::uint32_t height_px) {
    const std::uint32_t row = width_px * bytes_per_pixel(f);
    if (f == PixelFormat::none || width_px == 0 || height_px == 0 || width_px > kMaxImageWidth ||
        height_px > kMaxImageHeight || std::uint64_t{row} * height_px > capacity_bytes)
      return false;
    format = f, width = width_px, height = height_px, stride = row;
    return true;
  }
  std::uint8_t* pixels() { return reinterpret_cast<std::uint8_t*>(this + 1); }
  const std::uint8_t* pixels() const { return reinterpret_cast<const std::uint8_t*>(this + 1); }
  std::uint8_t* row(std::uint32_t y) { return pixels() + std::size_t{y} * stride; }
  const std::uint8_t* row(std::uint32_t y) const { return pixels() + std::size_t{y} * stride; }

  /// Bytes of pixels in use; never more than the capacity, whatever the other fields say.
  std::uint32_t bulk_used() const {
    const std::uint64_t n = std::uint64_t{stride} * height;
    return n > capacity_bytes ? capacity_bytes : static_cast<std::uint32_t>(n);
  }
  void set_bulk_capacity(std::uint32_t bytes) { capacity_bytes = bytes; }

  /// True when a header that came from elsewhere describes pixels that are all there: a format, dimensions within
  /// 1280x960, rows that do not overlap and end within `bytes` and the capacity.
  bool is_whole(std::size_t bytes) const {
    const std::uint64_t used = std::uint64_t{stride} * height;
    return bytes_per_pixel(format) != 0 && width > 0 && height > 0 && width <= kMaxImageWidth &&
           height <= kMaxImageHeight && stride >= width * bytes_per_pixel(format) && used <= bytes &&
           used <= capacity_bytes;
  }
};

template <>
struct Description<Image> {
  static constexpr std::string_view name = "Image", doc = "A camera image; pixel rows follow the header.";
  static constexpr std::string_view bulk = "data";
  static constexpr auto fields = describe(
      field<&Image::stamp>("ns", "mid-point of the exposure"), field<&Image::exposure_ns>("ns", "exposure time"),
      field<&Image::frame_number>("1", "counted by the camera"), field<&Image::width>("px"),
      field<&Image::height>("px"), field<&Image::stride>("B", "bytes from row to row"),
      enum_field<&Image::format>(kPixelFormatNames), field<&Image::capacity_bytes>("B", "room behind the header"));
};

}  // namespace sinew::msg
