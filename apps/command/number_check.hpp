#pragma once
// For the files that describe options.
#include <CLI/CLI.hpp>
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

}  // namespace sinew::app
