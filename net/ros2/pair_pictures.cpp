// Pictures and the models of their cameras.
#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>

#include "msg/camera_model.hpp"
#include "msg/image.hpp"
#include "msg/ros2_image.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {
namespace {

struct EncodingOf {
  msg::PixelFormat format;
  std::string_view other;  // another name for the same bytes
};
constexpr EncodingOf kEncodings[] = {{msg::PixelFormat::mono8, "8UC1"},
                                     {msg::PixelFormat::rgb8, "rgb8"},
                                     {msg::PixelFormat::bgr8, "8UC3"},
                                     {msg::PixelFormat::yuyv, "yuv422_yuy2"}};

bool put_camera(const Context& c, double fx, double fy, double cx, double cy, const std::array<double, 5>& d) {
  at(c, "distortion_model").text = "plumb_bob";
  put_numbers(at(c, "d"), d, d.size());
  const double k[] = {fx, 0, cx, 0, fy, cy, 0, 0, 1}, r[] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
               p[] = {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0};
  put_numbers(at(c, "k"), k, 9);
  put_numbers(at(c, "r"), r, 9);
  put_numbers(at(c, "p"), p, 12);
  return true;
}

}  // namespace

bool write_image(const Context& c, const void* own) {
  const auto& image = *static_cast<const msg::Image*>(own);
  if (!image.is_whole(image.bulk_used())) return false;
  at(c, "encoding").text = msg::ros2_encoding(image.format);
  at(c, "data").bytes = {image.pixels(), image.bulk_used()};
  return true;
}

const char* read_image(const Context& c, void* own) {
  auto& image = *static_cast<msg::Image*>(own);
  const std::string& encoding = at(c, "encoding").text;
  const auto found = std::find_if(std::begin(kEncodings), std::end(kEncodings), [&](const EncodingOf& e) {
    return encoding == msg::ros2_encoding(e.format) || encoding == e.other;
  });
  if (found == std::end(kEncodings)) return "an encoding other than mono8, rgb8, bgr8 and yuv422_yuy2";
  const std::int64_t width = at(c, "width").integer(), height = at(c, "height").integer(),
                     step = at(c, "step").integer();
  const std::span<const std::uint8_t> data = at(c, "data").bytes;
  if (width > msg::kMaxImageWidth || height > msg::kMaxImageHeight) return "an image of more than 1280 x 960";
  if (!image.format_as(found->format, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)))
    return "an image of no size, or larger than its topic takes";
  if (step < image.stride || static_cast<std::uint64_t>(step) * static_cast<std::uint64_t>(height) > data.size())
    return "rows that are not all there";
  for (std::uint32_t y = 0; y < image.height; ++y)
    std::memcpy(image.row(y), data.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(step), image.stride);
  return nullptr;
}

bool write_picture(const Context& c, const void*) {
  if (c.picture.empty()) return false;
  at(c, "format").text = "jpeg";
  at(c, "data").bytes = c.picture;
  return true;
}

const char* read_picture(const Context& c, void* own) {
  if (!c.read_picture || !*c.read_picture) return "files of pictures are not read here";
  return (*c.read_picture)(at(c, "data").bytes, *static_cast<msg::Image*>(own));
}

bool write_camera_info(const Context& c, const void*) {
  const std::vector<double>& camera = c.options.camera;  // fx, fy, cx, cy
  std::array<double, 5> distortion{};
  std::copy_n(c.options.distortion.begin(), std::min(c.options.distortion.size(), distortion.size()),
              distortion.begin());
  return put_camera(c, camera[0], camera[1], camera[2], camera[3], distortion);
}

bool write_camera_model(const Context& c, const void* own) {
  const auto& model = *static_cast<const msg::CameraModel*>(own);
  return put_camera(c, model.fx_px, model.fy_px, model.cx_px, model.cy_px, model.distortion);
}

/// An empty model, as simulators without distortion send it, is one whose coefficients are all 0.
const char* read_camera_info(const Context& c, void* own) {
  auto& model = *static_cast<msg::CameraModel*>(own);
  const auto all_zero = [](const Value& values) {
    return std::all_of(values.items.begin(), values.items.end(), [](const Value& v) { return v.number() == 0; });
  };
  const Value& d = at(c, "d");
  const std::string& name = at(c, "distortion_model").text;
  if (name != "plumb_bob" && !all_zero(d)) return "a distortion model other than plumb_bob";
  if (d.items.size() > model.distortion.size() && !all_zero(d)) return "more than five coefficients of plumb_bob";
  if (at(c, "binning_x").integer() > 1 || at(c, "binning_y").integer() > 1) return "a picture of binned pixels";
  if (at(c, "roi.width").integer() > 0 || at(c, "roi.height").integer() > 0 || at(c, "roi.x_offset").integer() > 0 ||
      at(c, "roi.y_offset").integer() > 0)
    return "a region of a picture";
  const auto k = [&](std::size_t i) { return at(c, "k").items[i].number(); };
  model.fx_px = k(0), model.fy_px = k(4), model.cx_px = k(2), model.cy_px = k(5);
  for (std::size_t i = 0; i < std::min(d.items.size(), model.distortion.size()); ++i) {
    const auto number = finite(d.items[i]);
    if (!number) return "a number that is not finite";
    model.distortion[i] = *number;
  }
  if (!math::is_finite(model.fx_px + model.fy_px + model.cx_px + model.cy_px)) return "a number that is not finite";
  return model.fx_px > 0 && model.fy_px > 0 ? nullptr : "a camera that is not calibrated (its k is 0)";
}

}  // namespace sinew::ros2::detail
