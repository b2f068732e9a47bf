// Pictures as files, each beside its floor: JPEG beside tjCompress2 of the same picture as BGR, PNG beside libpng's
// level 1 (its size, too), TIFF beside memcpy. Pictures of cameras and of the simulator are given as PNG or JPEG files.
// usage: images_bench [PAIRS [FILE.jpg|FILE.png...]]
#include <png.h>
#include <turbojpeg.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "images/encode.hpp"
#include "pairs.hpp"

namespace sinew {
namespace {

using bench::keep;
using images::Kind;

struct Scene {
  std::string name;
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb, bgr, yuyv;

  images::PixelView as(msg::PixelFormat format) const {
    const auto& bytes = format == msg::PixelFormat::yuyv ? yuyv : format == msg::PixelFormat::bgr8 ? bgr : rgb;
    return {bytes, width, height, width * msg::bytes_per_pixel(format), format};
  }
};

void fill_others(Scene& s) {
  s.bgr.resize(s.rgb.size()), s.yuyv.resize(s.rgb.size() / 3 * 2);
  for (std::size_t i = 0; i < s.rgb.size(); ++i) s.bgr[i] = s.rgb[i / 3 * 3 + 2 - i % 3];
  for (std::size_t i = 0; i < s.rgb.size() / 3; ++i) {
    const double r = s.rgb[3 * i], g = s.rgb[3 * i + 1], b = s.rgb[3 * i + 2];
    const double luma = 0.299 * r + 0.587 * g + 0.114 * b;
    const double colour = i % 2 == 0 ? (b - luma) / 1.772 : (r - luma) / 1.402;
    s.yuyv[2 * i] = static_cast<std::uint8_t>(16.5 + luma * 219 / 255);
    s.yuyv[2 * i + 1] = static_cast<std::uint8_t>(128.5 + colour * 224 / 255);
  }
}

/// Soft shading, a dozen flat discs, noise of three grey levels: about what a camera of 640x480 sees.
Scene painted() {
  Scene s{"painted", 640, 480, {}, {}, {}};
  std::uint32_t random = 1;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      int c[3] = {72 + x / 13 + y / 12, 76 + x / 13 + y / 12, 70 + x / 13 + y / 12};
      for (int o = 0; o < 12; ++o) {
        const int dx = x - (50 + o % 4 * 170), dy = y - (70 + o / 4 * 160), r = 14 + 3 * o;
        if (dx * dx + dy * dy < r * r) c[0] = 40 + 16 * o, c[1] = 220 - 15 * o, c[2] = 30 + 60 * (o % 3);
      }
      for (const int value : c) {
        random = random * 1664525u + 1013904223u;
        s.rgb.push_back(static_cast<std::uint8_t>(value + int((random >> 24) % 7) - 3));
      }
    }
  fill_others(s);
  return s;
}

/// A file of a camera or of sinew-sim --render-test.
Scene loaded(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  Scene s{path.substr(path.rfind('/') + 1), 0, 0, {}, {}, {}};
  bool good = false;
  if (path.ends_with(".png")) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    good = png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) != 0;
    image.format = PNG_FORMAT_RGB;
    s.width = image.width, s.height = image.height;
    s.rgb.resize(PNG_IMAGE_SIZE(image));
    good = good && png_image_finish_read(&image, nullptr, s.rgb.data(), 0, nullptr) != 0;
  } else {
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    const tjhandle handle = tjInitDecompress();
    int width = 0, height = 0, samples = 0, colours = 0;
    good = tjDecompressHeader3(handle, data, bytes.size(), &width, &height, &samples, &colours) == 0;
    s.width = std::uint32_t(width), s.height = std::uint32_t(height);
    s.rgb.resize(std::size_t{3} * s.width * s.height);
    good = good && tjDecompress2(handle, data, bytes.size(), s.rgb.data(), width, 0, height, TJPF_RGB, 0) == 0;
    tjDestroy(handle);
  }
  if (!good || s.width % 2 != 0) std::fprintf(stderr, "%s: no picture of even width\n", path.c_str()), std::exit(2);
  fill_others(s);
  return s;
}

std::span<const std::byte> must(const hal::Result<std::span<const std::byte>>& file) {
  if (!file) std::fprintf(stderr, "%s\n", file.error().where), std::exit(2);
  return *file;
}

/// libpng at level 1 with the filters that it chooses itself, into memory.
std::size_t libpng_level_1(const Scene& s, std::vector<std::uint8_t>& out) {
  out.clear();
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep data, png_size_t n) {
        auto* to = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(p));
        to->insert(to->end(), data, data + n);
      },
      nullptr);
  png_set_IHDR(png, info, s.width, s.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, 1);
  png_write_info(png, info);
  for (std::uint32_t y = 0; y < s.height; ++y) png_write_row(png, s.rgb.data() + std::size_t{3} * s.width * y);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out.size();
}

bool measure(const Scene& s, int pairs) {
  std::printf("%s, %u x %u\n", s.name.c_str(), s.width, s.height);
  images::Encoder encoder;
  const auto yuyv = s.as(msg::PixelFormat::yuyv), bgr = s.as(msg::PixelFormat::bgr8),
             rgb = s.as(msg::PixelFormat::rgb8);
  const tjhandle handle = tjInitCompress();
  std::vector<std::uint8_t> out(tjBufSize(int(s.width), int(s.height), TJSAMP_444));
  bool good = true;
  for (const bool half : {true, false}) {
    const images::EncodeOptions options{.quality = 80,
                                        .chroma = half ? images::Chroma::yuv420 : images::Chroma::yuv422};
    const auto floor = [&] {
      std::uint8_t* file = out.data();
      unsigned long size = out.size();
      keep(tjCompress2(handle, s.bgr.data(), int(s.width), 0, int(s.height), TJPF_BGR, &file, &size,
                       half ? TJSAMP_420 : TJSAMP_422, 80, TJFLAG_NOREALLOC));
    };
    const std::string suffix = half ? "420" : "422";
    good &=
        bench::report(("jpeg_" + suffix + "_yuyv / tjCompress2").c_str(),
                      bench::alternate(
                          pairs, 20, [&] { keep(must(encoder.encode(yuyv, Kind::jpeg, {}, options)).size()); }, floor),
                      half ? 0.9 : 1.1);
    good &=
        bench::report(("jpeg_" + suffix + "_bgr8 / tjCompress2").c_str(),
                      bench::alternate(
                          pairs, 20, [&] { keep(must(encoder.encode(bgr, Kind::jpeg, {}, options)).size()); }, floor),
                      1.1);
  }
  tjDestroy(handle);
  const auto whole = [&] { keep(must(encoder.encode(yuyv, Kind::jpeg)).size()); };
  good &=
      bench::report("jpeg_yuyv, half / whole",
                    bench::alternate(
                        pairs, 20, [&] { keep(must(encoder.encode(yuyv, Kind::jpeg, {.scale = 0.5})).size()); }, whole),
                    1.0);
  good &= bench::report(
      "jpeg_yuyv, quarter of it / whole",
      bench::alternate(
          pairs, 20,
          [&] { keep(must(encoder.encode(yuyv, Kind::jpeg, {.width = s.width / 2, .height = s.height / 2})).size()); },
          whole),
      0.5);
  std::vector<std::uint8_t> file;
  good &= bench::report(
      "png_rgb8 / libpng level 1",
      bench::alternate(
          pairs, 3, [&] { keep(must(encoder.encode(rgb, Kind::png)).size()); }, [&] { keep(libpng_level_1(s, file)); }),
      0.5);
  const double size = double(must(encoder.encode(rgb, Kind::png)).size());
  good &= bench::report_figure("png_rgb8, size / libpng level 1", size / double(libpng_level_1(s, file)), 1.05, "x");
  std::vector<std::uint8_t> copy(s.rgb.size());
  const auto floor = [&] { std::memcpy(copy.data(), s.rgb.data(), copy.size()), keep(copy.data()); };
  good &= bench::report("tiff_rgb8 / memcpy",
                        bench::alternate(
                            pairs, 60, [&] { keep(must(encoder.encode(rgb, Kind::tiff)).size()); }, floor),
                        1.3);
  good &= bench::report("tiff_bgr8 / memcpy",
                        bench::alternate(
                            pairs, 60, [&] { keep(must(encoder.encode(bgr, Kind::tiff)).size()); }, floor),
                        0);
  good &= bench::report("bmp_yuyv / memcpy of rgb8",
                        bench::alternate(
                            pairs, 20, [&] { keep(must(encoder.encode(yuyv, Kind::bmp)).size()); }, floor),
                        0);
  return good;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 15;
  bool good = sinew::measure(sinew::painted(), pairs);
  for (int i = 2; i < argc; ++i) good &= sinew::measure(sinew::loaded(argv[i]), pairs);
  return good ? 0 : 1;
}
