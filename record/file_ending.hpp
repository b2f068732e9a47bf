#pragma once
#include <vector>

#include "record/chunk_contents.hpp"

namespace sinew::record {

/// The footer of a file and the summary before it, as written in the file.
struct FileEnding {
  Footer footer;
  Summary summary;
  std::vector<SummaryOffset> offsets;  // as the file claims
  std::vector<SummaryOffset> groups;   // as they really are
};

enum class SummaryState : std::uint8_t {
  whole,
  none,     // no footer, or a footer without a summary; `why` is `truncated`
  damaged,  // not to be used
};
SummaryState read_ending(hal::InputFile& file, const ReadLimits& limits, FileEnding& ending, FileProblem& why);

}  // namespace sinew::record
