// For any text, the parser ends with a robot or with problems that can be printed.
#include <cstdlib>

#include "apps/robot_file/robot_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 4096) return 0;
  const auto loaded = sinew::app::parse_robot(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz.toml");
  for (const auto& p : loaded.problems)
    if (p.key.empty() || p.allowed.empty()) std::abort();
  return 0;
}
