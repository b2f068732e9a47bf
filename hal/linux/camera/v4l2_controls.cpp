#include "hal/linux/camera/v4l2_controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace sinew::hal {
namespace {

constexpr std::size_t kMostControls = 512;  // a broken driver must not block us

std::string name_of(const char* text, std::size_t room) {
  std::string name;
  for (std::size_t i = 0; i < room && text[i]; ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (std::isalnum(c)) {
      name += static_cast<char>(std::tolower(c));
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

int one(V4l2Port& port, int fd, unsigned long request, v4l2_ext_control& control) {
  v4l2_ext_controls list;
  std::memset(&list, 0, sizeof list);
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &control;
  return port.ioctl(fd, request, &list);
}

v4l2_ext_control about(std::uint32_t id) {
  v4l2_ext_control control;
  std::memset(&control, 0, sizeof control);
  control.id = id;
  return control;
}

Errc control_error_kind(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
      return Errc::denied;
    case EBUSY:
      return Errc::busy;
    case ENODEV:
      return Errc::closed;
    default:
      return Errc::io;
  }
}

}  // namespace

V4l2Controls V4l2Controls::enumerate(V4l2Port& port, int fd) {
  V4l2Controls all;
  v4l2_query_ext_ctrl entry;
  std::memset(&entry, 0, sizeof entry);
  entry.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (all.list_.size() < kMostControls && port.ioctl(fd, VIDIOC_QUERY_EXT_CTRL, &entry) == 0) {
    const std::uint32_t id = entry.id;
    const bool number = entry.type == V4L2_CTRL_TYPE_INTEGER || entry.type == V4L2_CTRL_TYPE_INTEGER64;
    const bool choice = entry.type == V4L2_CTRL_TYPE_BOOLEAN || entry.type == V4L2_CTRL_TYPE_MENU ||
                        entry.type == V4L2_CTRL_TYPE_INTEGER_MENU;
    if ((number || choice) && !(entry.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_HAS_PAYLOAD))) {
      CameraControl control{.name = name_of(entry.name, sizeof entry.name),
                            .min = static_cast<double>(entry.minimum),
                            .max = static_cast<double>(entry.maximum),
                            .step = choice ? 1.0 : static_cast<double>(entry.step),
                            .value = static_cast<double>(entry.default_value),
                            .read_only = (entry.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0};
      if (id == V4L2_CID_EXPOSURE_ABSOLUTE) all.exposure_ = all.list_.size();
      if (id == V4L2_CID_EXPOSURE_AUTO) all.auto_exposure_ = all.list_.size();
      all.codes_.push_back(
          {id, number, entry.type == V4L2_CTRL_TYPE_INTEGER64, (entry.flags & V4L2_CTRL_FLAG_VOLATILE) != 0});
      // Two generations of drivers, one name: the kernel's present one.
      if (id == V4L2_CID_EXPOSURE_ABSOLUTE) control.name = "exposure_time_absolute";
      if (id == V4L2_CID_EXPOSURE_AUTO) control.name = "auto_exposure";
      all.list_.push_back(control);
      if (const auto value = all.get(port, fd, all.list_.size() - 1))
        all.list_.back().value = static_cast<double>(*value);
    }
    std::memset(&entry, 0, sizeof entry);
    entry.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return all;
}

Status V4l2Controls::check(const Wanted& wanted, std::string& why) const {
  std::string wrong;
  const auto say = [&wrong](const std::string& text) { wrong += (wrong.empty() ? "" : "; ") + text; };
  for (const auto& [name, value] : wanted) {
    const auto at = std::find_if(list_.begin(), list_.end(), [&n = name](const auto& c) { return c.name == n; });
    if (at == list_.end()) {
      std::string known;
      for (const CameraControl& c : list_) known += (known.empty() ? "" : "; ") + to_text(c);
      say("control " + name + " is not known; the device has: " + (known.empty() ? "none" : known));
    } else if (at->read_only) {
      say("control " + name + " is read only");
    } else if (!(value >= at->min && value <= at->max) || value != std::floor(value) ||
               (at->step > 1 && std::fmod(value - at->min, at->step) != 0)) {
      say("control " + name + " = " + std::to_string(value) + " is not allowed: " + to_text(*at));
    }
  }
  if (wrong.empty()) return {};
  why = wrong;
  return Error{Errc::bad_argument, "camera control"};
}

Status V4l2Controls::set(V4l2Port& port, int fd, const Wanted& wanted, std::string& why, Wanted* taken) const {
  Status result;
  std::string refused;
  for (const bool numbers : {false, true}) {
    for (std::size_t i = 0; i < list_.size(); ++i) {
      const auto want = wanted.find(list_[i].name);
      if (want == wanted.end() || codes_[i].number != numbers) continue;
      auto control = about(codes_[i].id);
      const auto value = static_cast<std::int64_t>(want->second);
      if (codes_[i].wide) {
        control.value64 = value;
      } else {
        control.value = static_cast<std::int32_t>(value);
      }
      const int said = one(port, fd, VIDIOC_S_EXT_CTRLS, control);
      if (said == 0) {
        if (taken) taken->insert(*want);
        continue;
      }
      refused += (refused.empty() ? "" : "; ") + list_[i].name + ": " + std::strerror(-said);
      result = Error{control_error_kind(-said), "VIDIOC_S_EXT_CTRLS", -said};
    }
  }
  if (!refused.empty()) why = "the device refused " + refused;
  return result;
}

std::optional<std::int64_t> V4l2Controls::get(V4l2Port& port, int fd, std::size_t index) const {
  auto control = about(codes_[index].id);
  if (one(port, fd, VIDIOC_G_EXT_CTRLS, control) < 0) return std::nullopt;
  return codes_[index].wide ? static_cast<std::int64_t>(control.value64) : static_cast<std::int64_t>(control.value);
}

std::int64_t V4l2Controls::exposure_ns(V4l2Port& port, int fd) const {
  constexpr std::int64_t kUnitNs = 100'000;  // 100 us
  if (!exposure_) return 0;
  if (auto_exposure_ && !codes_[*exposure_].volatile_value) {
    // In automatic exposure the control keeps what was set last, unless it is marked as read from the sensor each time.
    const auto mode = get(port, fd, *auto_exposure_);
    if (!mode || (*mode != V4L2_EXPOSURE_MANUAL && *mode != V4L2_EXPOSURE_SHUTTER_PRIORITY)) return 0;
  }
  const auto value = get(port, fd, *exposure_);
  return value && *value > 0 && *value < 1'000'000'000 ? *value * kUnitNs : 0;
}

}  // namespace sinew::hal
