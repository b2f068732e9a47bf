#include <algorithm>

#include "images/file_writers.hpp"

#ifdef SINEW_TURBOJPEG
#include <turbojpeg.h>
#endif

namespace sinew::images {

#ifdef SINEW_TURBOJPEG
namespace {

std::uint32_t even(std::uint32_t n) { return (n + 1) / 2 * 2; }

int subsampling(Chroma chroma) { return chroma == Chroma::yuv420 ? TJSAMP_420 : TJSAMP_422; }

int pixel_format(RowSource::Order order) {
  if (order == RowSource::Order::grey) return TJPF_GRAY;
  return order == RowSource::Order::bgr ? TJPF_BGR : TJPF_RGB;
}

/// Makes room for any JPEG of this size, so that the library does not allocate the result.
unsigned long make_room(const Area& area, int samples, Buffer<std::uint8_t>& out) {
  const unsigned long bound = tjBufSize(int(area.out_width), int(area.out_height), samples);
  return bound == static_cast<unsigned long>(-1) || !out.at_least(bound) ? 0 : bound;
}

File finished(int status, const std::uint8_t* file, unsigned long size) {
  if (status != 0) return hal::Error{hal::Errc::io, "jpeg: libjpeg-turbo could not compress it", 0};
  return std::as_bytes(std::span<const std::uint8_t>(file, size));
}

/// Three planes in one memory, as TurboJPEG wants them: luma of whole pairs of pixels, for yuv420 also of whole pairs
/// of rows.
struct Planes {
  std::uint32_t width, height, chroma_width, chroma_height;
  std::uint8_t *y, *u, *v;

  static std::size_t bytes(std::uint32_t width, std::uint32_t height) {
    return 2 * std::size_t{even(width)} * even(height);
  }
  Planes(std::uint8_t* memory, std::uint32_t width_px, std::uint32_t height_px, bool half_rows)
      : width(width_px),
        height(height_px),
        chroma_width((width_px + 1) / 2),
        chroma_height(half_rows ? (height_px + 1) / 2 : height_px),
        y(memory),
        u(y + std::size_t{stride()} * even(height_px)),
        v(u + std::size_t{chroma_width} * chroma_height) {}
  std::uint32_t stride() const { return even(width); }
  std::uint8_t* luma(std::uint32_t row) const { return y + std::size_t{stride()} * row; }
  /// Repeats the last column and row where the picture ends in the middle of a pair.
  void fill_up() const {
    for (std::uint32_t i = 0; i < height && width % 2 == 1; ++i) luma(i)[width] = luma(i)[width - 1];
    if (height % 2 == 1) std::copy_n(luma(height - 1), stride(), luma(height));
  }
};

/// The planes of a part of a yuyv picture. A part that begins in the middle of a pair gets the mean colour of the two
/// pairs that each of its own pairs lies in.
void take_planes(const PixelView& view, const Area& area, const Planes& to, std::uint8_t* spare) {
  const bool odd = area.x % 2 == 1;
  const std::uint32_t pairs = (area.width + (odd ? 2 : 1)) / 2, step = to.chroma_height < to.height ? 2 : 1;
  const auto row = [&](std::uint32_t y) {
    return view.bytes.data() + std::size_t{area.y + y} * view.stride + std::size_t{area.x / 2} * 4;
  };
  for (std::uint32_t y = 0; y < area.height; ++y) luma_of_yuyv(row(y) + (odd ? 2 : 0), area.width, to.luma(y));
  for (std::uint32_t y = 0; y < to.chroma_height; ++y) {
    std::uint8_t* const ends[2] = {to.u + std::size_t{to.chroma_width} * y, to.v + std::size_t{to.chroma_width} * y};
    std::uint8_t *const u = odd ? spare : ends[0], *const v = odd ? spare + pairs : ends[1];
    if (step * y + 1 < area.height && step == 2)
      mean_chroma_of_yuyv(row(2 * y), row(2 * y + 1), pairs, u, v);
    else
      chroma_of_yuyv(row(step * y), pairs, u, v);
    for (std::uint32_t k = 0; odd && k < to.chroma_width; ++k) {
      const std::uint32_t next = std::min(k + 1, pairs - 1);
      ends[0][k] = static_cast<std::uint8_t>((u[k] + u[next] + 1) >> 1);
      ends[1][k] = static_cast<std::uint8_t>((v[k] + v[next] + 1) >> 1);
    }
  }
}

bool scale_plane(BoxFilter& filter, const std::uint8_t* from, std::uint32_t from_stride, BoxFilter::Size in,
                 std::uint8_t* to, std::uint32_t to_stride, BoxFilter::Size out) {
  if (!filter.start(in, out, 1)) return false;
  const auto row = [&](std::uint32_t y) { return from + std::size_t{from_stride} * y; };
  for (std::uint32_t y = 0; y < out.height; ++y) filter.next(row, to + std::size_t{to_stride} * y);
  return true;
}

bool scale_planes(BoxFilter& filter, const Planes& from, const Planes& to) {
  const BoxFilter::Size in{from.chroma_width, from.chroma_height}, out{to.chroma_width, to.chroma_height};
  return scale_plane(filter, from.y, from.stride(), {from.width, from.height}, to.y, to.stride(),
                     {to.width, to.height}) &&
         scale_plane(filter, from.u, in.width, in, to.u, out.width, out) &&
         scale_plane(filter, from.v, in.width, in, to.v, out.width, out);
}

}  // namespace

bool JpegWriter::built() { return true; }

JpegWriter::~JpegWriter() {
  if (compressor_) tjDestroy(compressor_);
}

File JpegWriter::write(const PixelView& view, RowSource& rows, const Area& area, const EncodeOptions& options,
                       Buffer<std::uint8_t>& out) {
  if (!compressor_) compressor_ = tjInitCompress();
  if (!compressor_) return no_memory();
  return view.format == msg::PixelFormat::yuyv ? of_yuyv(view, area, options, out)
                                               : of_rows(view, rows, area, options, out);
}

File JpegWriter::of_rows(const PixelView& view, RowSource& rows, const Area& area, const EncodeOptions& options,
                         Buffer<std::uint8_t>& out) {
  const RowSource::Order order = order_of(view.format);
  const std::uint8_t* pixels =
      view.bytes.data() + std::size_t{area.y} * view.stride + std::size_t{area.x} * msg::bytes_per_pixel(view.format);
  std::size_t stride = view.stride;
  if (area.scaled()) {
    if (!rows.start(view, area, order)) return no_memory();
    stride = rows.row_bytes();
    std::uint8_t* const to = scaled_.at_least(stride * area.out_height);
    if (!to) return no_memory();
    for (std::uint32_t y = 0; y < area.out_height; ++y) rows.next(to + y * stride);
    pixels = to;
  }
  const int samples = order == RowSource::Order::grey ? TJSAMP_GRAY : subsampling(options.chroma);
  unsigned long size = make_room(area, samples, out);
  if (size == 0) return no_memory();
  std::uint8_t* file = out.get();
  const int status = tjCompress2(compressor_, pixels, int(area.out_width), int(stride), int(area.out_height),
                                 pixel_format(order), &file, &size, samples, options.quality, TJFLAG_NOREALLOC);
  return finished(status, file, size);
}

// Straight from the picture's luma and chroma: no RGB, which would lose time and values.
File JpegWriter::of_yuyv(const PixelView& view, const Area& area, const EncodeOptions& options,
                         Buffer<std::uint8_t>& out) {
  const bool half_rows = options.chroma == Chroma::yuv420;
  std::uint8_t* const memory = planes_.at_least(Planes::bytes(area.width, area.height));
  std::uint8_t* const spare = scaled_.at_least(Planes::bytes(area.out_width, area.out_height) + area.width + 2);
  if (!memory || !spare) return no_memory();
  Planes planes(memory, area.width, area.height, half_rows && !area.scaled());
  take_planes(view, area, planes, spare);
  if (area.scaled()) {
    const Planes smaller(spare, area.out_width, area.out_height, half_rows);
    if (!scale_planes(filter_, planes, smaller)) return no_memory();
    planes = smaller;
  }
  planes.fill_up();
  unsigned long size = make_room(area, subsampling(options.chroma), out);
  if (size == 0) return no_memory();
  const std::uint8_t* from[3] = {planes.y, planes.u, planes.v};
  const int strides[3] = {int(planes.stride()), int(planes.chroma_width), int(planes.chroma_width)};
  std::uint8_t* file = out.get();
  const int status =
      tjCompressFromYUVPlanes(compressor_, from, int(planes.width), strides, int(planes.height),
                              subsampling(options.chroma), &file, &size, options.quality, TJFLAG_NOREALLOC);
  return finished(status, file, size);
}

#else

bool JpegWriter::built() { return false; }
JpegWriter::~JpegWriter() = default;
File JpegWriter::write(const PixelView&, RowSource&, const Area&, const EncodeOptions&, Buffer<std::uint8_t>&) {
  return hal::Error{hal::Errc::not_supported, "jpeg: Sinew was built without libjpeg-turbo (Debian: libturbojpeg0-dev)",
                    0};
}

#endif

}  // namespace sinew::images
