// For any text: a reason, or a line that is written and read again as the same frame.
#include "wire/candump.hpp"

#include <array>
#include <cstdlib>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  wire::CandumpLine line;
  if (wire::candump_parse({reinterpret_cast<const char*>(data), size}, line) != nullptr) return 0;
  std::array<char, wire::kCandumpMax> text{};
  const std::size_t written = wire::candump_format(line.frame, line.interface, text);
  if (written == 0) std::abort();
  wire::CandumpLine back;
  if (wire::candump_parse({text.data(), written}, back) != nullptr) std::abort();
  if (back.frame.id != line.frame.id || back.frame.flags != line.frame.flags || back.frame.size != line.frame.size)
    std::abort();
  if (back.frame.data != line.frame.data || back.interface != line.interface) std::abort();
  return 0;
}
