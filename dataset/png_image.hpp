#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "msg/image.hpp"

namespace sinew::dataset {

/// A decoded picture, rows without padding.
struct DecodedImage {
  msg::PixelFormat format = msg::PixelFormat::none;  // mono8 or rgb8
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// Decodes a PNG: grey to mono8, colour (also by palette) to rgb8; of 16 bits the upper 8; transparency is dropped; no
/// gamma is applied, the values are the file's.
/// Errors:  false, with the reason in `why`: not a PNG, damaged, cut off, larger than 1280x960.
bool decode_png(std::span<const std::uint8_t> file, DecodedImage& out, std::string& why);

/// The pixels as a PNG file: mono8, rgb8, bgr8, or yuyv (BT.601, limited range) as colour. Rows are `stride` bytes
/// apart. Empty, with the reason in `why`: there are too few pixels, or none.
std::string encode_png(msg::PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t stride,
                       std::span<const std::uint8_t> pixels, std::string& why);

}  // namespace sinew::dataset
