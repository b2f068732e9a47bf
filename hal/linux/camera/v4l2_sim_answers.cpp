// The simulated camera's description of itself: formats, sizes, rates, controls. See v4l2_sim.hpp.
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "hal/linux/camera/v4l2_sim.hpp"

namespace sinew::hal {
namespace {

template <std::size_t N, class Char>
void put_text(Char (&to)[N], const std::string& text) {
  std::memset(to, 0, N);
  std::memcpy(to, text.data(), std::min(text.size(), N - 1));
}

v4l2_fract interval_of(double rate_hz) { return {1000, static_cast<std::uint32_t>(std::lround(rate_hz * 1000))}; }

std::uint32_t bytes_of_pixel(std::uint32_t code) {
  switch (code) {
    case V4L2_PIX_FMT_GREY:
      return 1;
    case V4L2_PIX_FMT_RGB24:
    case V4L2_PIX_FMT_BGR24:
      return 3;
    default:
      return 2;
  }
}

}  // namespace

int V4l2Sim::answer(File& file, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& said = *static_cast<v4l2_capability*>(argument);
      put_text(said.card, camera_.card);
      put_text(said.driver, camera_.driver);
      put_text(said.bus_info, camera_.bus_info);
      said.device_caps = camera_.capabilities;
      said.capabilities = camera_.capabilities | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
    case VIDIOC_ENUM_FRAMESIZES:
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate(request, argument);
    case VIDIOC_S_FMT:
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM:
      return formats(file, request, argument);
    case VIDIOC_QUERY_EXT_CTRL:
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
      return controls(request, argument);
    default:
      return buffers(file, request, argument);
  }
}

int V4l2Sim::enumerate(unsigned long request, void* argument) const {
  const auto offer = [this](std::uint32_t code) -> const V4l2SimCamera::Offer* {
    for (const auto& o : camera_.offers)
      if (o.code == code) return &o;
    return nullptr;
  };
  if (request == VIDIOC_ENUM_FMT) {
    auto& entry = *static_cast<v4l2_fmtdesc*>(argument);
    if (entry.index >= camera_.offers.size()) return -EINVAL;
    entry.pixelformat = camera_.offers[entry.index].code;
    put_text(entry.description, camera_.offers[entry.index].text);
    return 0;
  }
  if (!camera_.lists_sizes) return -ENOTTY;
  if (request == VIDIOC_ENUM_FRAMESIZES) {
    auto& entry = *static_cast<v4l2_frmsizeenum*>(argument);
    const auto* o = offer(entry.pixel_format);
    if (!o || entry.index >= (o->steps ? 1 : o->sizes.size())) return -EINVAL;
    if (o->steps) {
      entry.type = V4L2_FRMSIZE_TYPE_STEPWISE;
      entry.stepwise = {o->sizes[0].width, o->sizes[1].width, 2, o->sizes[0].height, o->sizes[1].height, 2};
    } else {
      entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      entry.discrete = {o->sizes[entry.index].width, o->sizes[entry.index].height};
    }
    return 0;
  }
  auto& entry = *static_cast<v4l2_frmivalenum*>(argument);
  const auto* o = offer(entry.pixel_format);
  if (!o || entry.index >= (o->steps ? 1 : o->rates.size())) return -EINVAL;
  if (o->steps) {
    entry.type = V4L2_FRMIVAL_TYPE_STEPWISE;
    entry.stepwise = {interval_of(o->rates[1]), interval_of(o->rates[0]), {1, 1000}};
  } else {
    entry.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    entry.discrete = interval_of(o->rates[entry.index]);
  }
  return 0;
}

int V4l2Sim::formats(File& file, unsigned long request, void* argument) {
  if (request == VIDIOC_S_FMT) {
    if (busy_) return -EBUSY;
    auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
    const V4l2SimCamera::Offer* best = &camera_.offers.front();
    for (const auto& o : camera_.offers)
      if (o.code == pix.pixelformat) best = &o;
    // As drivers do: the nearest size is taken, without an error.
    if (!best->steps) {
      const auto far = [&pix](const V4l2SimCamera::Size& s) {
        return std::abs(std::int64_t{s.width} - pix.width) + std::abs(std::int64_t{s.height} - pix.height);
      };
      const auto nearest = std::min_element(best->sizes.begin(), best->sizes.end(),
                                            [&far](const auto& a, const auto& b) { return far(a) < far(b); });
      pix.width = nearest->width, pix.height = nearest->height;
    }
    pix.pixelformat = best->code;
    pix.field = V4L2_FIELD_NONE;
    const std::uint32_t line = pix.width * bytes_of_pixel(pix.pixelformat) + camera_.padding_bytes;
    pix.bytesperline = pix.pixelformat == V4L2_PIX_FMT_MJPEG ? 0 : line;
    pix.sizeimage = line * pix.height;
    file.code = pix.pixelformat, file.width = pix.width, file.height = pix.height, file.line = pix.bytesperline;
    file.image_bytes = pix.sizeimage;
    file.rate_hz = best->rates.empty() ? 0 : best->rates.front();
    return 0;
  }
  auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
  if (file.rate_hz == 0) return -ENOTTY;
  if (request == VIDIOC_S_PARM && capture.timeperframe.numerator != 0)
    file.rate_hz = static_cast<double>(capture.timeperframe.denominator) / capture.timeperframe.numerator;
  for (auto& c : camera_.controls)
    if (camera_.exposure_in_period && c.id == V4L2_CID_EXPOSURE_ABSOLUTE && file.rate_hz > 0)
      c.max = static_cast<std::int64_t>(1e4 / file.rate_hz), c.value = std::min(c.value, c.max);
  capture.capability = V4L2_CAP_TIMEPERFRAME;
  capture.timeperframe = interval_of(file.rate_hz);
  return 0;
}

int V4l2Sim::controls(unsigned long request, void* argument) {
  if (request == VIDIOC_QUERY_EXT_CTRL) {
    auto& entry = *static_cast<v4l2_query_ext_ctrl*>(argument);
    const std::uint32_t after = entry.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
    const V4l2SimCamera::Control* next = nullptr;  // the kernel lists by number
    for (const auto& c : camera_.controls)
      if (c.id > after && (!next || c.id < next->id)) next = &c;
    if (!next) return -EINVAL;
    entry.id = next->id, entry.type = next->type, entry.flags = next->flags;
    put_text(entry.name, next->name);
    entry.minimum = next->min, entry.maximum = next->max, entry.default_value = next->value;
    entry.step = static_cast<std::uint64_t>(next->step);
    return 0;
  }
  const auto& list = *static_cast<const v4l2_ext_controls*>(argument);
  if (list.count != 1) return -EINVAL;
  v4l2_ext_control& wanted = list.controls[0];
  for (auto& c : camera_.controls) {
    if (c.id != wanted.id) continue;
    if (request == VIDIOC_G_EXT_CTRLS) {
      wanted.value = static_cast<std::int32_t>(c.value);
      return 0;
    }
    if (c.flags & V4L2_CTRL_FLAG_READ_ONLY) return -EACCES;
    if (wanted.value < c.min || wanted.value > c.max) return -ERANGE;
    c.value = wanted.value;
    return 0;
  }
  return -EINVAL;
}

}  // namespace sinew::hal
