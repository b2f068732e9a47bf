#pragma once
#include <string>

namespace sinew::test {

/// The checkout that this program was built from, without a slash at its end: for tests that read robot files.
/// Thread:  any.   RT: no, it allocates.
std::string source_dir();

}  // namespace sinew::test
