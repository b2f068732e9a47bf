#pragma once
#include <cstddef>

namespace sinew::test {

/// From now on operator new throws for more than `bytes`, in all threads but the caller's. For programs that link
/// refusing_new.cpp.
void refuse_above(std::size_t bytes);

}  // namespace sinew::test
