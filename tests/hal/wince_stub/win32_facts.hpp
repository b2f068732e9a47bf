#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::hal {

/// A constant, a size or a place in a structure, under the system's name for it.
struct Win32Fact {
  std::string name;
  std::int64_t value;
};

/// As in the system's headers. These and coredll.hpp declare the same functions with other types, so each has its own
/// file.
std::vector<Win32Fact> system_facts();

}  // namespace sinew::hal
