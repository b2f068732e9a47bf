#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "record/reader.hpp"

namespace sinew::record {

/// Goes through the time of a file backwards, to find the newest messages before an instant without reading everything
/// before it:
///     BackwardWindows windows(reader, until);
///     while (auto window = windows.next(topics)) ...;  // keeps the last message of each topic, drops topics it found
/// Each window begins where a block with one of the topics begins, and ends where the one before it began: a message
/// that is found in a window is newer than all in later windows.
/// Thread:  owner.
/// Owner:   the reader must outlive it.
class BackwardWindows {
 public:
  /// `until`: log time, included.
  BackwardWindows(const Reader& reader, std::uint64_t until) : reader_(reader), until_(until) {}
  /// The messages of these topics in the next earlier window. Nothing: no earlier block has any of these topics.
  std::optional<Query> next(const std::vector<std::string>& topics);

 private:
  const Reader& reader_;
  std::optional<std::uint64_t> until_;  // nothing: the beginning is reached
};

}  // namespace sinew::record
