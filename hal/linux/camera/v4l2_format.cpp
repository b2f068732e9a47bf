#include "hal/linux/camera/v4l2_format.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>

#include "hal/linux/camera/jpeg_decoder.hpp"

namespace sinew::hal {
namespace {

constexpr std::uint32_t kMostEntries = 256;  // no honest driver lists more; a broken one must not block us
constexpr double kSameRate = 0.01;           // 29.97 counts as 30

struct Range {
  std::uint32_t min = 0, max = 0, step = 1;
  bool holds(std::uint32_t v) const { return v >= min && v <= max && (v - min) % std::max(step, 1U) == 0; }
};
/// One entry of the size list: a single size, or a range with steps.
struct Sizes {
  Range width, height;
  bool holds(std::uint32_t w, std::uint32_t h) const { return width.holds(w) && height.holds(h); }
  bool single() const { return width.min == width.max && height.min == height.max; }
};
/// One entry of the rate list, in frames per second.
struct Rates {
  double min = 0, max = 0;
  bool holds(double hz) const { return hz >= min * (1 - kSameRate) && hz <= max * (1 + kSameRate); }
  bool single() const { return min == max; }
};
struct Format {
  std::uint32_t fourcc = 0;
  std::string text;
};

template <class T>
T cleared() {
  T t;
  std::memset(&t, 0, sizeof t);
  return t;
}

std::string text_of(const std::uint8_t* bytes, std::size_t room) {
  const char* text = reinterpret_cast<const char*>(bytes);
  return std::string(text, strnlen(text, room));
}

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>(fourcc >> (8 * i) & 0x7F);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", v);
  return text;
}

std::string size_text(std::uint32_t w, std::uint32_t h) { return std::to_string(w) + "x" + std::to_string(h); }

double rate_of(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

std::vector<Format> formats(V4l2Port& port, int fd) {
  std::vector<Format> all;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    auto entry = cleared<v4l2_fmtdesc>();
    entry.index = i, entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (port.ioctl(fd, VIDIOC_ENUM_FMT, &entry) < 0) break;
    all.push_back({entry.pixelformat, text_of(entry.description, sizeof entry.description)});
  }
  return all;
}

std::vector<Sizes> sizes(V4l2Port& port, int fd, std::uint32_t fourcc) {
  std::vector<Sizes> all;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    auto entry = cleared<v4l2_frmsizeenum>();
    entry.index = i, entry.pixel_format = fourcc;
    if (port.ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &entry) < 0) break;
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      all.push_back(
          {{entry.discrete.width, entry.discrete.width, 1}, {entry.discrete.height, entry.discrete.height, 1}});
      continue;
    }
    const auto& s = entry.stepwise;  // continuous: the same with steps of 1
    all.push_back({{s.min_width, s.max_width, s.step_width}, {s.min_height, s.max_height, s.step_height}});
    break;
  }
  return all;
}

std::vector<Rates> rates(V4l2Port& port, int fd, std::uint32_t fourcc, std::uint32_t w, std::uint32_t h) {
  std::vector<Rates> all;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    auto entry = cleared<v4l2_frmivalenum>();
    entry.index = i, entry.pixel_format = fourcc, entry.width = w, entry.height = h;
    if (port.ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      all.push_back({rate_of(entry.discrete), rate_of(entry.discrete)});
      continue;
    }
    all.push_back(
        {rate_of(entry.stepwise.max), rate_of(entry.stepwise.min)});  // the longest interval is the lowest rate
    break;
  }
  return all;
}

std::string rates_text(const std::vector<Rates>& all) {
  std::string text;
  for (const Rates& r : all)
    text += (text.empty() ? "" : ", ") + number(r.min) + (r.single() ? "" : " to " + number(r.max));
  return text.empty() ? text : text + " frames/s";
}

std::string sizes_text(const std::vector<Sizes>& all) {
  std::string text;
  for (const Sizes& s : all) {
    text += (text.empty() ? "" : ", ") + size_text(s.width.min, s.height.min);
    if (!s.single())
      text += " to " + size_text(s.width.max, s.height.max) + " in steps of " + size_text(s.width.step, s.height.step);
  }
  return text;
}

Error refused_format(int result, const char* where) {
  switch (-result) {
    case EBUSY:
      return {Errc::busy, where, -result};
    case ENODEV:
      return {Errc::closed, where, -result};
    case EACCES:
    case EPERM:
      return {Errc::denied, where, -result};
    default:
      return {Errc::io, where, -result};
  }
}

/// Checks that the device lists the wanted picture, with pixels named `fourcc`: else an error with the device's list.
Status is_listed(V4l2Port& port, int fd, const CameraSpec& spec, std::uint32_t fourcc, std::string& why) {
  const std::string wanted = size_text(spec.width, spec.height) + " " + msg::pixel_format_name(spec.format);
  const auto offered = formats(port, fd);
  if (std::none_of(offered.begin(), offered.end(), [&](const Format& f) { return f.fourcc == fourcc; })) {
    why =
        std::string(msg::pixel_format_name(spec.format)) + " is not offered; the device has: " + v4l2_offers(port, fd);
    return Error{Errc::not_supported, "camera format"};
  }
  const auto of_size = sizes(port, fd, fourcc);
  const auto holds = [&](const Sizes& s) { return s.holds(spec.width, spec.height); };
  if (!of_size.empty() && std::none_of(of_size.begin(), of_size.end(), holds)) {
    why = wanted + " is not offered; it has " + sizes_text(of_size);
    return Error{Errc::bad_argument, "camera size"};
  }
  const auto of_rate = rates(port, fd, fourcc, spec.width, spec.height);
  const auto keeps = [&](const Rates& r) { return r.holds(spec.rate_hz); };
  if (spec.rate_hz > 0 && !of_rate.empty() && std::none_of(of_rate.begin(), of_rate.end(), keeps)) {
    why = wanted + " at " + number(spec.rate_hz) + " frames/s is not offered; it has " + rates_text(of_rate);
    return Error{Errc::bad_argument, "camera rate"};
  }
  return {};
}

/// The format to ask for: the image's own, or MJPEG where the device has only that and it can be decoded in one pass.
Result<std::uint32_t> choose(V4l2Port& port, int fd, const CameraSpec& spec, std::string& why) {
  const std::uint32_t fourcc = v4l2_code(spec.format);
  const Status raw = is_listed(port, fd, spec, fourcc, why);
  if (raw) return fourcc;
  std::string none;
  if (!is_listed(port, fd, spec, V4L2_PIX_FMT_MJPEG, none)) return raw.error();
  if (JpegDecoder::gives(spec.format)) return std::uint32_t{V4L2_PIX_FMT_MJPEG};
  why += JpegDecoder::built() ? "; it has this as MJPEG, which gives mono8, rgb8 or bgr8"
                              : "; it has this as MJPEG, which this build cannot decode (SINEW_TURBOJPEG)";
  return raw.error();
}

/// The rate that the device reports; an error when it is not the wanted one.
Result<double> agree_on_rate(V4l2Port& port, int fd, const CameraSpec& spec, std::string& why) {
  auto parameters = cleared<v4l2_streamparm>();
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (port.ioctl(fd, VIDIOC_G_PARM, &parameters) < 0) return 0.0;  // a device without rates
  auto& interval = parameters.parm.capture.timeperframe;
  if (spec.rate_hz > 0 && parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) {
    interval.numerator = 1000;
    interval.denominator = static_cast<std::uint32_t>(std::lround(spec.rate_hz * 1000));
    if (const int set = port.ioctl(fd, VIDIOC_S_PARM, &parameters); set < 0) {
      why = "setting " + number(spec.rate_hz) + " frames/s: " + std::strerror(-set);
      return refused_format(set, "VIDIOC_S_PARM");
    }
  }
  const double got = rate_of(interval);
  if (spec.rate_hz > 0 && got > 0 && !Rates{spec.rate_hz, spec.rate_hz}.holds(got)) {
    why = "asked for " + number(spec.rate_hz) + " frames/s, the device gives " + number(got);
    return Error{Errc::bad_argument, "camera rate"};
  }
  return got;
}

}  // namespace

std::uint32_t v4l2_code(msg::PixelFormat format) {
  switch (format) {
    case msg::PixelFormat::mono8:
      return V4L2_PIX_FMT_GREY;
    case msg::PixelFormat::rgb8:
      return V4L2_PIX_FMT_RGB24;
    case msg::PixelFormat::bgr8:
      return V4L2_PIX_FMT_BGR24;
    case msg::PixelFormat::yuyv:
      return V4L2_PIX_FMT_YUYV;
    case msg::PixelFormat::none:
      break;
  }
  return 0;
}

Result<V4l2Identity> v4l2_identify(V4l2Port& port, int fd) {
  auto answer = cleared<v4l2_capability>();
  if (const int said = port.ioctl(fd, VIDIOC_QUERYCAP, &answer); said < 0) {
    if (said == -ENOTTY || said == -EINVAL) return Error{Errc::not_supported, "VIDIOC_QUERYCAP", -said};
    return refused_format(said, "VIDIOC_QUERYCAP");
  }
  const std::uint32_t can = answer.capabilities & V4L2_CAP_DEVICE_CAPS ? answer.device_caps : answer.capabilities;
  return V4l2Identity{.card = text_of(answer.card, sizeof answer.card),
                      .driver = text_of(answer.driver, sizeof answer.driver),
                      .bus_info = text_of(answer.bus_info, sizeof answer.bus_info),
                      .captures = (can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_TOUCH)) == V4L2_CAP_VIDEO_CAPTURE,
                      .multiplanar = (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0,
                      .streams = (can & V4L2_CAP_STREAMING) != 0};
}

std::string v4l2_offers(V4l2Port& port, int fd) {
  std::string text;
  for (const Format& f : formats(port, fd)) {
    text += (text.empty() ? "" : "; ") + fourcc_text(f.fourcc) + " (" + f.text + ")";
    std::string of_format;
    for (const Sizes& s : sizes(port, fd, f.fourcc)) {
      of_format += (of_format.empty() ? ": " : ", ") + sizes_text({s});
      const std::string at = rates_text(rates(port, fd, f.fourcc, s.width.min, s.height.min));
      if (!at.empty()) of_format += " at " + at;
    }
    text += of_format;
  }
  return text.empty() ? "no formats at all" : text;
}

Result<V4l2Picture> v4l2_agree(V4l2Port& port, int fd, const CameraSpec& spec, std::string& why) {
  const std::uint32_t row = spec.width * msg::bytes_per_pixel(spec.format);
  if (v4l2_code(spec.format) == 0 || spec.width == 0 || spec.height == 0 || spec.width > msg::kMaxImageWidth ||
      spec.height > msg::kMaxImageHeight) {
    why = "images are mono8, rgb8, bgr8 or yuyv, 1x1 to " + size_text(msg::kMaxImageWidth, msg::kMaxImageHeight) +
          "; asked was " + size_text(spec.width, spec.height) + " " + msg::pixel_format_name(spec.format);
    return Error{Errc::bad_argument, "camera format"};
  }
  if (!std::isfinite(spec.rate_hz) || spec.rate_hz < 0 || spec.rate_hz > 100'000) {
    why = "a rate of " + number(spec.rate_hz) + " frames/s is not possible; 0 keeps the device's rate";
    return Error{Errc::bad_argument, "camera rate"};
  }
  const auto chosen = choose(port, fd, spec, why);
  if (!chosen) return chosen.error();
  const std::uint32_t fourcc = *chosen;
  why.clear();
  auto asked = cleared<v4l2_format>();
  asked.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  asked.fmt.pix.width = spec.width, asked.fmt.pix.height = spec.height;
  asked.fmt.pix.pixelformat = fourcc;
  asked.fmt.pix.field = V4L2_FIELD_NONE;  // whole pictures, not half ones of an interlaced signal
  if (const int set = port.ioctl(fd, VIDIOC_S_FMT, &asked); set < 0) {
    why = "setting " + size_text(spec.width, spec.height) + " " + msg::pixel_format_name(spec.format) + ": " +
          (set == -EBUSY ? "another program uses the device; `fuser -v` on its path says which" : std::strerror(-set));
    return refused_format(set, "VIDIOC_S_FMT");
  }
  const v4l2_pix_format& got = asked.fmt.pix;
  const bool whole = got.field == V4L2_FIELD_NONE || got.field == V4L2_FIELD_ANY;
  if (got.width != spec.width || got.height != spec.height || got.pixelformat != fourcc || !whole) {
    why = "asked for " + size_text(spec.width, spec.height) + " " + fourcc_text(fourcc) + ", the device gives " +
          size_text(got.width, got.height) + " " + fourcc_text(got.pixelformat) + (whole ? "" : ", interlaced");
    return Error{Errc::bad_argument, "camera format"};
  }
  const bool is_jpeg = fourcc == V4L2_PIX_FMT_MJPEG;
  V4l2Picture picture{.format = spec.format,
                      .width = got.width,
                      .height = got.height,
                      .is_jpeg = is_jpeg,
                      .bytes_per_line = is_jpeg ? 0 : std::max(got.bytesperline, row),
                      .image_bytes = got.sizeimage};
  const std::uint64_t least = std::uint64_t{picture.bytes_per_line} * (picture.height - 1) + row;
  if (is_jpeg ? got.sizeimage == 0 : (got.bytesperline != 0 && got.bytesperline < row) || picture.image_bytes < least) {
    why = "the driver's sizes do not fit together: " + std::to_string(got.bytesperline) + " bytes per line, " +
          std::to_string(got.sizeimage) + " bytes per image for " + size_text(got.width, got.height);
    return Error{Errc::bad_data, "VIDIOC_S_FMT"};
  }
  const auto rate = agree_on_rate(port, fd, spec, why);
  if (!rate) return rate.error();
  picture.rate_hz = *rate;
  return picture;
}

}  // namespace sinew::hal
