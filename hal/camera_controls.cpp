#include "hal/camera_controls.hpp"

#include <cstdio>

namespace sinew::hal {
namespace {

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", v);
  return text;
}

}  // namespace

std::string to_text(const CameraControl& c) {
  std::string text = c.name + " " + number(c.min) + " to " + number(c.max);
  if (c.step > 1) text += " in steps of " + number(c.step);
  text += ", is " + number(c.value);
  return c.read_only ? text + ", read only" : text;
}

std::optional<std::size_t> CameraControls::find(std::string_view name) const {
  const auto& all = controls();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == name) return i;
  return std::nullopt;
}

std::string CameraControls::list() const {
  std::string text;
  for (const CameraControl& c : controls()) text += (text.empty() ? "" : "; ") + to_text(c);
  return text.empty() ? "no controls at all" : text;
}

}  // namespace sinew::hal
