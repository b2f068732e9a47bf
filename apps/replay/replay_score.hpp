#pragma once
// What one replay of one file gives: between the process that executed it and the one that sums up, as a line of JSON.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "record/run/comparison.hpp"

namespace sinew::app {

struct ReplayScore {
  record::Deviation now, recorded;
  std::uint64_t missing = 0;
  std::vector<std::string> stopped{};  // modules that could not be executed to the end, in words
  std::string failed{};                // why there was no replay at all, for any point; empty: there was
};

/// One line; numbers keep all their bits.
std::string to_line(const ReplayScore& score);
/// The last line of `text` that is one: modules may have printed others. Nothing: there is none.
std::optional<ReplayScore> parse_replay_score(const std::string& text);

}  // namespace sinew::app
