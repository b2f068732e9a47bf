#pragma once
// For the files that describe options.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>

namespace sinew::app {

/// For options: a number from `least` to `most`. Refuses NaN, which the ranges of the library accept.
inline CLI::Validator number(double least, double most = 1e9) {
  return {[least, most](std::string& text) {
            double value = 0;
            if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return std::string();
            return text + " is not a number from " + CLI::detail::to_string(least) + " to " +
                   CLI::detail::to_string(most);
          },
          "", "number"};
}

/// For options: a whole number from `least` to `most`. Every option of an unsigned type needs it: the library makes
/// 18446744073709551615 of -1.
inline CLI::Validator whole(std::uint64_t least = 0, std::uint64_t most = UINT64_MAX) {
  return {[least, most](std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto read = std::from_chars(text.data(), end, value);
            if (read.ec == std::errc() && read.ptr == end && value >= least && value <= most) return std::string();
            return text + " is not an integer from " + std::to_string(least) + " to " + std::to_string(most);
          },
          "", "whole"};
}

}  // namespace sinew::app
