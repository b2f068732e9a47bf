#pragma once
// Errors on the board or on the way there, as texts that say what to do.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// Exit codes of the scripts in apps/deploy.
enum class BoardStep : int {
  folder = 10,
  unpack = 11,
  write = 12,
  start = 13,
  check = 14,
  swap = 15,
  no_previous = 16,
  user = 20,
  data = 21,
  reach = 22,
  unit = 23,
  enable = 24,
  ill = 25,
  running = 26,
  started = 27,
  no_data = 30,
  unreadable = 31,
};

/// Libraries that the board lacks, by the words of its loader: "libfmt.so.9 (Debian: apt-get install libfmt9)".
std::vector<std::string> missing_libraries(std::string_view loader);
/// The loader's words about a C or C++ library that is too old for the program; empty: none is too old.
std::string too_old_library(std::string_view loader);

/// Why a script, or ssh itself (255), did not do its work: `errors` is what came on its standard error.
std::string explain_failure(int code, std::string_view errors, const std::string& host, const std::string& folder);

}  // namespace sinew::app
