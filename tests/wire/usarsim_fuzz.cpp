// For any bytes: lines that are refused, or lines that are written and read again with the same keys and values.
#include "wire/text/usarsim.hpp"

#include <cstdlib>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static wire::UsarLine line, back;
  wire::UsarLines lines;
  for (std::size_t i = 0; i <= size; ++i) {
    if (!lines.push(i < size ? static_cast<char>(data[i]) : '\n')) continue;
    const wire::UsarError error = wire::parse_usarsim(lines.line(), line);
    if (line.count > wire::kUsarParts) std::abort();
    for (const wire::UsarPart& part : line.parts()) {
      if (part.key.empty()) std::abort();
      for (const bool comma : {false, true}) {
        const std::size_t count = wire::usar_count(part.value, comma);
        for (std::size_t k = 0; k < count + 2; ++k) {
          if (wire::usar_number(part.value, k, comma) && k >= count) std::abort();
          if (k >= count && !wire::usar_item(part.value, k, comma).empty()) std::abort();
        }
      }
    }
    if (error != wire::UsarError::none) continue;
    std::array<char, 2 * wire::kUsarLine> text{};
    wire::UsarWriter out(text);
    out.type(line.type);
    for (std::size_t k = 0; k < line.count; ++k) {
      const wire::UsarPart& part = line.part[k];
      if (k == 0 || part.brace != line.part[k - 1].brace) {
        if (k > 0) out.close();
        out.open();
      }
      out.word(part.key);
      if (!part.value.empty()) out.word(part.value);
    }
    if (line.count > 0) out.close();
    if (wire::parse_usarsim(out.line(), back) != wire::UsarError::none) std::abort();
    if (back.type != line.type || back.count != line.count) std::abort();
    for (std::size_t k = 0; k < line.count; ++k)
      if (back.part[k].key != line.part[k].key || back.part[k].value != line.part[k].value) std::abort();
  }
  return 0;
}
