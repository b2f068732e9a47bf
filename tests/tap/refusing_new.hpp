#pragma once
#include <cstddef>

namespace sinew::test {

/// From now on operator new throws for more bytes than that, in all threads but the caller's. Of programs that link
/// refusing_new.cpp.
void refuse_above(std::size_t bytes);

}  // namespace sinew::test
