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

/// As the system's headers have it. They and coredll.hpp declare the same functions with other types: one file for
/// each.
std::vector<Win32Fact> system_facts();

}  // namespace sinew::hal
