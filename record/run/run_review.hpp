#pragma once
// Compares the contents of a recorded run with what the file says of itself.
#include <map>

#include "record/reader.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {

struct RunReview {
  bool is_run = false;   // it names the modules and ports of a run
  bool is_part = false;  // cut out of a recording, or a later file of a split one: a late beginning is no loss
  Texts run;             // "sinew.run"
  bool ended = false;    // has its own verdict; without one the recording was cut off, or goes on in other files
  Texts said_verdict, said_losses;

  std::vector<ModuleVerdict> verdict;           // from its contents
  std::map<std::string, Losses> lost_messages;  // by topic: named by a step, but missing
  std::map<std::string, Losses> lost_steps;     // by thread
  std::map<std::string, Losses> other_pixels;   // images with other pixels than were seen
  std::vector<std::string> differences;         // in words: claims of the file that its contents contradict
};

/// Reads everything twice: the messages, then the steps that name them. Unreadable content counts as lost.
RunReview review(Reader& reader);

/// Metadata that marks copies of a part; their verdict stays that of the whole.
inline constexpr std::string_view kEditedName = "sinew.edited";

}  // namespace sinew::record
