// For any text: a template that is refused in words, or one that writes no more than fits, and the same again.
#include "wire/text/text_template.hpp"

#include <cstdlib>
#include <cstring>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  double value = 1.5;
  std::size_t room = 64;
  if (size >= sizeof value + 1) {
    std::memcpy(&value, data, sizeof value);
    room = data[sizeof value];
    data += sizeof value + 1, size -= sizeof value + 1;
  }
  std::string why;
  const auto made = wire::TextTemplate::parse({reinterpret_cast<const char*>(data), size}, {"land", "takeoff"}, why);
  if (made.has_value() != why.empty()) std::abort();
  if (!made) return 0;
  const std::vector<double> values(made->values(), value);
  std::vector<char> out(room), again(room);
  std::uint32_t sequence = 1, second = 1;
  const std::size_t used = made->write(values, sequence, out);
  if (used > room || made->write(values, second, again) != used || sequence != second) std::abort();
  if (used > 0 && std::memcmp(out.data(), again.data(), used) != 0) std::abort();
  return 0;
}
