#include "net/bridge/picture_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace sinew::net {
namespace {

constexpr std::array<std::uint8_t, 3> kJpegHead{0xff, 0xd8, 0xff};
constexpr std::array<std::uint8_t, 4> kPngHead{0x89, 'P', 'N', 'G'};
constexpr const char* kTooLarge = "an image of no size, or larger than its topic takes";

template <std::size_t N>
bool begins_with(std::span<const std::uint8_t> file, const std::array<std::uint8_t, N>& head) {
  return file.size() >= N && std::equal(head.begin(), head.end(), file.begin());
}

}  // namespace

const char* PictureReader::read(std::span<const std::uint8_t> file, msg::Image& out) {
  if (begins_with(file, kJpegHead)) return read_jpeg(file, out);
  if (begins_with(file, kPngHead)) return read_png(file, out);
  return "a file that is neither JPEG nor PNG";
}

const char* PictureReader::read_jpeg(std::span<const std::uint8_t> file, msg::Image& out) {
  if (!hal::JpegDecoder::built()) return "JPEG, which this build does not read";
  const auto shape = hal::JpegDecoder::shape_of(file);
  if (!shape) return "a JPEG file that is damaged";
  const msg::PixelFormat format = shape->is_grey ? msg::PixelFormat::mono8 : msg::PixelFormat::rgb8;
  if (!out.format_as(format, shape->width, shape->height)) return kTooLarge;
  if (!jpeg_ || shape->width != jpeg_shape_.width || shape->height != jpeg_shape_.height ||
      shape->is_grey != jpeg_shape_.is_grey) {
    jpeg_ = std::make_unique<hal::JpegDecoder>(format, shape->width, shape->height);
    jpeg_shape_ = *shape;
  }
  return jpeg_->decode(file, out) ? nullptr : "a JPEG file that is damaged";
}

const char* PictureReader::read_png(std::span<const std::uint8_t> file, msg::Image& out) {
  std::string why;
  if (!dataset::decode_png(file, png_, why)) return "a PNG file that is damaged, or of more than 1280 x 960 pixels";
  if (!out.format_as(png_.format, png_.width, png_.height)) return kTooLarge;
  std::memcpy(out.pixels(), png_.pixels.data(), png_.pixels.size());
  return nullptr;
}

}  // namespace sinew::net
