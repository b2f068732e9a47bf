// For any bytes and each form: an error, or parts that lie within the line and have keys.
#include "wire/text/text_fields.hpp"

#include <cstdlib>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static wire::UsarLine line;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const auto form : {wire::TextForm::usarsim, wire::TextForm::fields, wire::TextForm::words}) {
    const wire::UsarError error = wire::parse_text(form, text, line);
    if (line.count > wire::kUsarParts) std::abort();
    std::size_t sum = line.type.size();
    for (const wire::UsarPart& part : line.parts()) {
      if (part.key.empty()) std::abort();
      sum += part.value.size();
      static_cast<void>(wire::usar_number(part.value, 1));
    }
    if (error == wire::UsarError::empty && line.count > 0) std::abort();
    if (sum > size + 8) std::abort();  // "reply" and "state" are not the line's own
  }
  return 0;
}
