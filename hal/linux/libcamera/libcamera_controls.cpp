// libcamera's controls as numbers with names. See libcamera_session.hpp.
#include <algorithm>
#include <cmath>

#include "hal/linux/libcamera/libcamera_session.hpp"

namespace sinew::hal {
namespace {

/// Nothing for a value that is no single number.
std::optional<double> number(const libcamera::ControlValue& value) {
  if (value.isArray()) return std::nullopt;
  switch (value.type()) {
    case libcamera::ControlTypeBool:
      return value.get<bool>() ? 1.0 : 0.0;
    case libcamera::ControlTypeByte:
      return value.get<std::uint8_t>();
    case libcamera::ControlTypeInteger32:
      return value.get<std::int32_t>();
    case libcamera::ControlTypeInteger64:
      return static_cast<double>(value.get<std::int64_t>());
    case libcamera::ControlTypeFloat:
      return value.get<float>();
    default:
      return std::nullopt;
  }
}

libcamera::ControlValue value_of(libcamera::ControlType type, double v) {
  switch (type) {
    case libcamera::ControlTypeBool:
      return libcamera::ControlValue(v != 0);
    case libcamera::ControlTypeByte:
      return libcamera::ControlValue(static_cast<std::uint8_t>(v));
    case libcamera::ControlTypeInteger32:
      return libcamera::ControlValue(static_cast<std::int32_t>(v));
    case libcamera::ControlTypeInteger64:
      return libcamera::ControlValue(static_cast<std::int64_t>(v));
    default:
      return libcamera::ControlValue(static_cast<float>(v));
  }
}

}  // namespace

void LibcameraSession::list_controls() {
  for (const auto& [code, info] : camera_->controls()) {
    const auto min = number(info.min()), max = number(info.max());
    // FrameDurationLimits and the like are lists of numbers though their limits are single ones; the rate sets that
    // one.
    const bool list = code->name() == "FrameDurationLimits" || code->name() == "ColourGains";
    if (!min || !max || info.min().type() != code->type() || list) continue;
    const bool whole = code->type() != libcamera::ControlTypeFloat;
    controls_.push_back({code->name(), *min, *max, whole ? 1.0 : 0.0, number(info.def()).value_or(*min), false});
    codes_.push_back(code);
  }
}

Status LibcameraSession::check(const Wanted& wanted, std::string& why) const {
  std::string wrong;
  for (const auto& [name, value] : wanted) {
    const auto at =
        std::find_if(controls_.begin(), controls_.end(), [&n = name](const auto& c) { return c.name == n; });
    if (at != controls_.end() && value >= at->min && value <= at->max && (at->step < 1 || value == std::floor(value)))
      continue;
    wrong += (wrong.empty() ? "control " : "; control ") + name;
    if (at != controls_.end()) {
      wrong += " = " + std::to_string(value) + " is not allowed: " + to_text(*at);
      continue;
    }
    std::string known;
    for (const CameraControl& c : controls_) known += (known.empty() ? "" : "; ") + to_text(c);
    wrong += " is not known; the camera has: " + (known.empty() ? "none" : known);
  }
  if (wrong.empty()) return {};
  why = wrong;
  return Error{Errc::bad_argument, "camera control"};
}

void LibcameraSession::put(libcamera::ControlList& list, const Wanted& wanted) const {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    const auto want = wanted.find(controls_[i].name);
    if (want != wanted.end()) list.set(codes_[i]->id(), value_of(codes_[i]->type(), want->second));
  }
}

}  // namespace sinew::hal
