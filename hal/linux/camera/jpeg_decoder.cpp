#include "hal/linux/camera/jpeg_decoder.hpp"

#ifdef SINEW_TURBOJPEG
#include <turbojpeg.h>
#endif

namespace sinew::hal {

#ifdef SINEW_TURBOJPEG
namespace {

// Cameras do not send streams of many scans; such a stream could block us for long.
constexpr int kFlags = TJFLAG_LIMITSCANS | TJFLAG_STOPONWARNING;

int pixel_format(msg::PixelFormat format) {
  switch (format) {
    case msg::PixelFormat::mono8:
      return TJPF_GRAY;
    case msg::PixelFormat::rgb8:
      return TJPF_RGB;
    case msg::PixelFormat::bgr8:
      return TJPF_BGR;
    case msg::PixelFormat::yuyv:
    case msg::PixelFormat::none:
      break;
  }
  return TJPF_UNKNOWN;
}

}  // namespace

struct JpegDecoder::Library {
  tjhandle handle = nullptr;
  msg::PixelFormat format = msg::PixelFormat::none;
  int width = 0, height = 0;

  ~Library() {
    if (handle) tjDestroy(handle);
  }
  bool decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept;
};

bool JpegDecoder::built() { return true; }
bool JpegDecoder::gives(msg::PixelFormat format) { return pixel_format(format) != TJPF_UNKNOWN; }

std::optional<JpegDecoder::Shape> JpegDecoder::shape_of(std::span<const std::uint8_t> jpeg) {
  const tjhandle handle = jpeg.empty() ? nullptr : tjInitDecompress();
  if (!handle) return std::nullopt;
  int w = 0, h = 0, subsampling = 0, colours = 0;
  const bool read = tjDecompressHeader3(handle, jpeg.data(), jpeg.size(), &w, &h, &subsampling, &colours) == 0;
  tjDestroy(handle);
  if (!read || w <= 0 || h <= 0) return std::nullopt;  // a cut-off head has no size
  return Shape{static_cast<std::uint32_t>(w), static_cast<std::uint32_t>(h), colours == TJCS_GRAY};
}

JpegDecoder::JpegDecoder(msg::PixelFormat format, std::uint32_t width, std::uint32_t height)
    : library_(std::make_unique<Library>()) {
  library_->handle = tjInitDecompress();
  library_->format = format;
  library_->width = static_cast<int>(width), library_->height = static_cast<int>(height);
  if (!library_->handle) library_.reset();
}

bool JpegDecoder::decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept {
  if (!library_ || jpeg.empty() || out.format != library_->format || !gives(out.format)) return false;
  if (library_->decode(jpeg, out)) return true;
  // After a broken-off header, libjpeg-turbo 2.1.5 reads the next header as its rest.
  if (library_->handle) tjDestroy(library_->handle);
  library_->handle = tjInitDecompress();
  return false;
}

bool JpegDecoder::Library::decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept {
  int w = 0, h = 0, subsampling = 0, colours = 0;
  if (!handle || tjDecompressHeader3(handle, jpeg.data(), jpeg.size(), &w, &h, &subsampling, &colours) != 0)
    return false;
  if (w != width || h != height || static_cast<int>(out.width) != w || static_cast<int>(out.height) != h) return false;
  return tjDecompress2(handle, jpeg.data(), jpeg.size(), out.pixels(), width, static_cast<int>(out.stride), height,
                       pixel_format(out.format), kFlags) == 0;
}

#else

struct JpegDecoder::Library {};
bool JpegDecoder::built() { return false; }
bool JpegDecoder::gives(msg::PixelFormat) { return false; }
std::optional<JpegDecoder::Shape> JpegDecoder::shape_of(std::span<const std::uint8_t>) { return std::nullopt; }
JpegDecoder::JpegDecoder(msg::PixelFormat, std::uint32_t, std::uint32_t) {}
bool JpegDecoder::decode(std::span<const std::uint8_t>, msg::Image&) noexcept { return false; }

#endif

JpegDecoder::~JpegDecoder() = default;

}  // namespace sinew::hal
