#include "apps/robot_file/param_value.hpp"

#include <charconv>

namespace sinew::app {

rt::ParamValue param_value(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  std::int64_t integer = 0;
  const char* const end = text.data() + text.size();
  if (auto r = std::from_chars(text.data(), end, integer); r.ec == std::errc() && r.ptr == end) return integer;
  double number = 0;
  if (auto r = std::from_chars(text.data(), end, number); r.ec == std::errc() && r.ptr == end) return number;
  return text;
}

}  // namespace sinew::app
