#include "wire/text/text_fields.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

UsarError parse_words(std::string_view line, UsarLine& out) {
  const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
  out.type = line.substr(0, end);
  const std::string_view rest = without_blanks(line.substr(end));
  if (!rest.empty()) out.part[out.count++] = {"value", rest, 0};
  return UsarError::none;
}

UsarError parse_fields(std::string_view line, UsarLine& out) {
  if (line.find_first_of(":=") == std::string_view::npos) {
    out.type = "reply";
    out.part[out.count++] = {"text", line, 0};
    return UsarError::none;
  }
  out.type = "state";
  for (std::uint32_t field = 0; !line.empty(); ++field) {
    const std::size_t end = std::min(line.find(';'), line.size());
    const std::string_view one = without_blanks(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
    if (one.empty()) continue;
    const std::size_t cut = one.find_first_of(":=");
    if (cut == std::string_view::npos || without_blanks(one.substr(0, cut)).empty()) return UsarError::text;
    if (out.count == out.part.size()) return UsarError::too_many;
    out.part[out.count++] = {without_blanks(one.substr(0, cut)), without_blanks(one.substr(cut + 1)), field};
  }
  return UsarError::none;
}

}  // namespace

UsarError parse_text(TextForm form, std::string_view line, UsarLine& out) noexcept {
  if (form == TextForm::usarsim) return parse_usarsim(line, out);
  out.type = {};
  out.count = 0;
  line = without_blanks(line);
  if (line.empty()) return UsarError::empty;
  return form == TextForm::words ? parse_words(line, out) : parse_fields(line, out);
}

}  // namespace sinew::wire
