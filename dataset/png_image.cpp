#include "dataset/png_image.hpp"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

namespace sinew::dataset {
namespace {

/// The data of libpng's callbacks. Plain data: libpng leaves by longjmp, which runs no destructors.
struct Source {
  const std::uint8_t* data;
  std::size_t left;
  char why[160];
};

void read_bytes(png_structp png, png_bytep to, std::size_t n) {
  auto* from = static_cast<Source*>(png_get_io_ptr(png));
  if (n > from->left) png_error(png, "the file is cut off");
  std::memcpy(to, from->data, n);
  from->data += n;
  from->left -= n;
}

[[noreturn]] void fail(png_structp png, png_const_charp text) {
  auto* from = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(from->why, text, sizeof from->why - 1);
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}  // of ancillary chunks; the pixels are not concerned

struct Shape {
  std::uint32_t width, height, channels;
};

/// Header and transformations. Leaves by longjmp when the file is bad.
Shape begin(png_structp png, png_infop info, Source* from) {
  png_set_read_fn(png, from, read_bytes);
  png_set_user_limits(png, msg::kMaxImageWidth, msg::kMaxImageHeight);
  png_set_chunk_cache_max(png, 16);
  png_set_chunk_malloc_max(png, 1 << 20);
  png_read_info(png, info);
  if (png_get_color_type(png, info) == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (png_get_color_type(png, info) == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png, info) < 8)
    png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return {png_get_image_width(png, info), png_get_image_height(png, info), png_get_channels(png, info)};
}

/// Checks the size in the header before libpng does: libpng's message would not help.
bool too_large(std::span<const std::uint8_t> file, std::uint32_t& width, std::uint32_t& height) {
  constexpr std::size_t kWidthAt = 16, kHeightAt = 20;  // signature, length and type of the first chunk before them
  if (file.size() < kHeightAt + 4) return false;
  width = png_get_uint_32(file.data() + kWidthAt);
  height = png_get_uint_32(file.data() + kHeightAt);
  return width > msg::kMaxImageWidth || height > msg::kMaxImageHeight;
}

// No object with a destructor may live in these two: longjmp comes here.
bool read_shape(png_structp png, png_infop info, Source* from, Shape* shape) {
  if (setjmp(png_jmpbuf(png))) return false;
  *shape = begin(png, info, from);
  return true;
}

bool read_rows(png_structp png, std::uint8_t* pixels, const Shape* shape, int passes) {
  if (setjmp(png_jmpbuf(png))) return false;
  const std::size_t stride = std::size_t{shape->width} * shape->channels;
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t y = 0; y < shape->height; ++y) png_read_row(png, pixels + y * stride, nullptr);
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

bool decode_png(std::span<const std::uint8_t> file, DecodedImage& out, std::string& why) {
  Source from{file.data(), file.size(), {}};
  if (file.size() < 8 || png_sig_cmp(file.data(), 0, 8) != 0) {
    why = "not a PNG file";
    return false;
  }
  if (std::uint32_t width = 0, height = 0; too_large(file, width, height)) {
    why = std::to_string(width) + " x " + std::to_string(height) + " pixels; at most " +
          std::to_string(msg::kMaxImageWidth) + " x " + std::to_string(msg::kMaxImageHeight);
    return false;
  }
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &from, fail, ignore);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  Shape shape{};
  bool good = info != nullptr && read_shape(png, info, &from, &shape);
  if (good && shape.channels != 1 && shape.channels != 3) {
    std::strcpy(from.why, "neither grey nor colour");
    good = false;
  }
  if (good) {
    out.format = shape.channels == 1 ? msg::PixelFormat::mono8 : msg::PixelFormat::rgb8;
    out.width = shape.width, out.height = shape.height;
    out.pixels.resize(std::size_t{shape.width} * shape.height * shape.channels);
    const int passes = png_get_interlace_type(png, info) == PNG_INTERLACE_NONE ? 1 : 7;
    good = read_rows(png, out.pixels.data(), &shape, passes);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!good) why = from.why[0] != 0 ? from.why : "out of memory";
  return good;
}

namespace {

std::uint8_t clamped(double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0) + 0.5); }

/// Pairs of pixels share their colour: Y U Y V, BT.601 with limited range (Y 16 to 235, U and V 16 to 240).
std::vector<std::uint8_t> rgb_of_yuyv(std::uint32_t width, std::uint32_t height, std::uint32_t stride,
                                      std::span<const std::uint8_t> pixels) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(std::size_t{width} * height * 3);
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::uint8_t* pair = pixels.data() + std::size_t{y} * stride + (x & ~1u) * 2;
      const double luma = (pair[(x & 1) * 2] - 16.0) * 255 / 219;
      const double u = (pair[1] - 128.0) * 255 / 224, v = (pair[3] - 128.0) * 255 / 224;
      rgb.push_back(clamped(luma + 1.402 * v));
      rgb.push_back(clamped(luma - 0.344136 * u - 0.714136 * v));
      rgb.push_back(clamped(luma + 1.772 * u));
    }
  return rgb;
}

}  // namespace

std::string encode_png(msg::PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t stride,
                       std::span<const std::uint8_t> pixels, std::string& why) {
  const bool yuyv = format == msg::PixelFormat::yuyv;
  const std::uint64_t row = std::uint64_t{width + (yuyv ? width & 1 : 0)} * msg::bytes_per_pixel(format);
  if (row == 0 || height == 0 || width > 65535 || stride < row || pixels.size() < std::uint64_t{stride} * height) {
    why = std::to_string(pixels.size()) + " bytes of pixels are no image of " + std::to_string(width) + " x " +
          std::to_string(height);
    return {};
  }
  std::vector<std::uint8_t> rgb;
  if (yuyv) rgb = rgb_of_yuyv(width, height, stride, pixels), pixels = rgb, stride = 3 * width;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width, image.height = height;
  image.format = PNG_FORMAT_RGB;
  if (format == msg::PixelFormat::mono8) image.format = PNG_FORMAT_GRAY;
  if (format == msg::PixelFormat::bgr8) image.format = PNG_FORMAT_BGR;
  const auto row_stride = static_cast<png_int_32>(stride);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string file(size, '\0');
  if (png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), row_stride, nullptr) == 0) {
    why = image.message;
    return {};
  }
  file.resize(size);
  return file;
}

}  // namespace sinew::dataset
