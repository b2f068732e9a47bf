#pragma once
// What the contents of a recorded run say, held against what the file says of itself.
#include <map>

#include "record/reader.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {

struct RunReview {
  bool is_run = false;   // it says which modules and ports there were
  bool is_part = false;  // cut out of a recording, or a later file of a split one: that it begins late is no loss
  Texts run;             // "sinew.run"
  bool ended = false;  // it has a verdict of its own; without one the recording was cut off, or goes on in other files
  Texts said_verdict, said_losses;

  std::vector<ModuleVerdict> verdict;           // from its contents
  std::map<std::string, Losses> lost_messages;  // by topic: named by a step, not there
  std::map<std::string, Losses> lost_steps;     // by thread
  std::map<std::string, Losses> other_pixels;   // images whose pixels are not those that were seen
  std::vector<std::string> differences;         // in words: where what it says is not what is in it
};

/// Reads everything twice: the messages, then the steps that name them. What cannot be read counts as lost.
RunReview review(Reader& reader);

/// What copies of a part are marked with, as metadata; their verdict stays that of the whole.
inline constexpr std::string_view kEditedName = "sinew.edited";

}  // namespace sinew::record
