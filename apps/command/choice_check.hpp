#pragma once
// For the files that describe options.
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "hal/did_you_mean.hpp"

namespace sinew::app {

/// For options: one of these words; an error names the one that was probably meant.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  const CLI::Validator member = CLI::IsMember(words);
  CLI::Validator check = member;  // with its description, for the help
  check.operation([member, words](std::string& text) {
    const std::string why = member(text);
    return why.empty() ? why : why + hal::did_you_mean(text, words);
  });
  return check;
}

}  // namespace sinew::app
