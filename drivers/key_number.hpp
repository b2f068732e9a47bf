#pragma once
#include <charconv>
#include <cmath>
#include <string>

namespace sinew::drivers {

/// A number as people write it into a robot file: "0.5", "500", "100000", "1e-06".
inline std::string key_number(double value) {
  const double size = std::abs(value);
  const bool plain = size == 0 || (size >= 1e-4 && size < 1e10);
  char text[64];
  const auto end = plain ? std::to_chars(text, text + sizeof text, value, std::chars_format::fixed).ptr
                         : std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

}  // namespace sinew::drivers
