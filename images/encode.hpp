#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "hal/result.hpp"
#include "msg/image.hpp"

/// Pictures as files for other programs: JPEG, PNG, TIFF and BMP from the pixels of an image message, whole, in part or
/// smaller.
namespace sinew::images {

enum class Kind : std::uint8_t { jpeg, png, tiff, bmp };

/// The kind of files with this ending: jpg, jpeg, png, tif, tiff, bmp, without the dot and in lower case.
std::optional<Kind> kind_of(std::string_view ending);

/// As HTTP names it: "image/jpeg".
const char* media_type(Kind kind);

/// False for JPEG in a build without libjpeg-turbo.
bool is_built(Kind kind);

/// Larger pictures are refused: sums over all pixels of one channel fit into 32 bits.
inline constexpr std::uint32_t kMaxSide = 16384, kMaxPixels = 1u << 24;

/// Pixels to encode.
/// Shape:   height x width, row-major, top-left first, `stride` bytes from row to row: mono8, rgb8, bgr8 or yuyv. Rows
///          of yuyv hold whole pairs, also where the width is odd.
/// Owner:   the pixels' owner; encode() reads them only while it runs.
struct PixelView {
  std::span<const std::uint8_t> bytes;  // all that may be read; bytes behind the last row are ignored
  std::uint32_t width = 0, height = 0, stride = 0;
  msg::PixelFormat format = msg::PixelFormat::none;
};

/// The pixels of a message. encode() refuses a message whose fields contradict each other.
inline PixelView view(const msg::Image& image) {
  return {{image.pixels(), image.capacity_bytes}, image.width, image.height, image.stride, image.format};
}

/// Which part of a picture, and how large. A region or a scale costs less than the whole picture.
/// Units:   pixels of the picture before scaling.
struct Cut {
  std::uint32_t x = 0, y = 0;
  std::uint32_t width = 0, height = 0;  // 0: to the border; what is beyond the border is left out
  double scale = 1;  // 0 < scale <= 1; each pixel is the average of the area that it replaces; at least 1 x 1 remains
  bool operator==(const Cut&) const = default;
};

enum class Chroma : std::uint8_t {
  yuv420,  // one colour for 2 x 2 pixels
  yuv422,  // one colour for 2 pixels of a row, as yuyv has it
};

/// JPEG only; the other kinds keep every value.
struct EncodeOptions {
  int quality = 80;  // 1 to 100, libjpeg's scale
  Chroma chroma = Chroma::yuv420;
  bool operator==(const EncodeOptions&) const = default;
};

/// Encodes one picture after the other and keeps its buffers.
/// Values:  yuyv is BT.601 with limited range (Y 16 to 235), as V4L2 cameras and the simulator give it. JPEG takes its
///          luma and colour, spread to full range as JFIF wants it; the other kinds get RGB. JPEG of mono8 is grey. PNG
///          and TIFF of mono8 have one channel, BMP always has 24 bits.
/// Thread:  owner.
/// RT:      no. Our code allocates nothing after the first picture of a size and kind; libjpeg-turbo does, for each.
/// Errors:  bad_argument: no pixels, fewer bytes than the rows need, larger than kMaxSide or kMaxPixels, a region that
///          begins outside of the picture, a scale or quality out of range; not_supported: see is_built();
///          out_of_memory; io: the library failed. `where` says it in words.
class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  /// The whole file. It stays valid until the next call.
  hal::Result<std::span<const std::byte>> encode(const PixelView& view, Kind kind, const Cut& cut = {},
                                                 const EncodeOptions& options = {}) noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;  // null: no memory
};

}  // namespace sinew::images
