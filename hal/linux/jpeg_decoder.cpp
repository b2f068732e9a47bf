#include "hal/linux/jpeg_decoder.hpp"

#ifdef SINEW_TURBOJPEG
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <vector>
#endif

namespace sinew::hal {

#ifdef SINEW_TURBOJPEG
namespace {

// A stream of many scans is no camera's, and could hold us for long.
constexpr int kFlags = TJFLAG_LIMITSCANS | TJFLAG_STOPONWARNING;
constexpr std::uint8_t kNoColour = 128;

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

/// Every second chroma sample of a row, from one that has one sample for each `step` pixels.
std::uint8_t chroma(const std::uint8_t* row, std::uint32_t x, std::uint32_t step) {
  return step == 1 ? static_cast<std::uint8_t>((row[x] + row[x + 1] + 1) / 2) : row[x / step];
}

}  // namespace

struct JpegDecoder::Library {
  tjhandle handle = nullptr;
  msg::PixelFormat format = msg::PixelFormat::none;
  int width = 0, height = 0;
  std::array<std::vector<std::uint8_t>, 3> planes;  // yuyv: room for any subsampling

  ~Library() {
    if (handle) tjDestroy(handle);
  }
  bool decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept;
  bool into_planes(std::span<const std::uint8_t> jpeg, int subsampling, msg::Image& out) noexcept;
};

bool JpegDecoder::built() { return true; }

JpegDecoder::JpegDecoder(msg::PixelFormat format, std::uint32_t width, std::uint32_t height)
    : library_(std::make_unique<Library>()) {
  library_->handle = tjInitDecompress();
  library_->format = format;
  library_->width = static_cast<int>(width), library_->height = static_cast<int>(height);
  if (!library_->handle) library_.reset();
  if (!library_ || format != msg::PixelFormat::yuyv) return;
  for (int component = 0; component < 3; ++component) {
    std::size_t most = 0;
    for (int subsampling = 0; subsampling < TJ_NUMSAMP; ++subsampling) {
      const unsigned long bytes = tjPlaneSizeYUV(component, library_->width, 0, library_->height, subsampling);
      if (bytes != static_cast<unsigned long>(-1)) most = std::max<std::size_t>(most, bytes);
    }
    library_->planes[static_cast<std::size_t>(component)].resize(most);
  }
}

bool JpegDecoder::decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept {
  if (!library_ || jpeg.empty() || out.format != library_->format) return false;
  if (library_->decode(jpeg, out)) return true;
  // libjpeg-turbo 2.1.5 reads the next header as if it were the rest of one that broke off.
  if (library_->handle) tjDestroy(library_->handle);
  library_->handle = tjInitDecompress();
  return false;
}

bool JpegDecoder::Library::decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept {
  int w = 0, h = 0, subsampling = 0, colours = 0;
  if (!handle || tjDecompressHeader3(handle, jpeg.data(), jpeg.size(), &w, &h, &subsampling, &colours) != 0)
    return false;
  if (w != width || h != height || static_cast<int>(out.width) != w || static_cast<int>(out.height) != h) return false;
  if (out.format == msg::PixelFormat::yuyv) {
    const bool has_luma = colours == TJCS_YCbCr || colours == TJCS_GRAY;
    return has_luma && into_planes(jpeg, subsampling, out);
  }
  return tjDecompress2(handle, jpeg.data(), jpeg.size(), out.pixels(), width, static_cast<int>(out.stride), height,
                       pixel_format(out.format), kFlags) == 0;
}

bool JpegDecoder::Library::into_planes(std::span<const std::uint8_t> jpeg, int subsampling, msg::Image& out) noexcept {
  if (subsampling < 0 || subsampling >= TJ_NUMSAMP) return false;
  std::array<unsigned char*, 3> to{planes[0].data(), planes[1].data(), planes[2].data()};
  if (tjDecompressToYUVPlanes(handle, jpeg.data(), jpeg.size(), to.data(), width, nullptr, height, kFlags) != 0)
    return false;
  const bool grey = subsampling == TJSAMP_GRAY;
  const auto y_stride = static_cast<std::size_t>(tjPlaneWidth(0, width, subsampling));
  const auto c_stride = grey ? 0 : static_cast<std::size_t>(tjPlaneWidth(1, width, subsampling));
  const auto step_x = static_cast<std::uint32_t>(tjMCUWidth[subsampling] / 8);
  const auto step_y = static_cast<std::uint32_t>(tjMCUHeight[subsampling] / 8);
  for (std::uint32_t row = 0; row < out.height; ++row) {
    const std::uint8_t* y = planes[0].data() + row * y_stride;
    const std::uint8_t* u = planes[1].data() + row / step_y * c_stride;
    const std::uint8_t* v = planes[2].data() + row / step_y * c_stride;
    std::uint8_t* to_row = out.row(row);
    for (std::uint32_t x = 0; x + 1 < out.width; x += 2, to_row += 4) {
      to_row[0] = y[x], to_row[2] = y[x + 1];
      to_row[1] = grey ? kNoColour : chroma(u, x, step_x);
      to_row[3] = grey ? kNoColour : chroma(v, x, step_x);
    }
    if (out.width % 2 != 0) {  // half a pair: luma and the first chroma
      to_row[0] = y[out.width - 1];
      to_row[1] = grey ? kNoColour : u[(out.width - 1) / step_x];
    }
  }
  return true;
}

#else

struct JpegDecoder::Library {};
bool JpegDecoder::built() { return false; }
JpegDecoder::JpegDecoder(msg::PixelFormat, std::uint32_t, std::uint32_t) {}
bool JpegDecoder::decode(std::span<const std::uint8_t>, msg::Image&) noexcept { return false; }

#endif

JpegDecoder::~JpegDecoder() = default;

}  // namespace sinew::hal
