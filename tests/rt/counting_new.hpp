#pragma once
#include <cstdint>

namespace sinew::test {

/// Calls of operator new since the start of a program that links counting_new.cpp.
std::uint64_t allocations();

}  // namespace sinew::test
