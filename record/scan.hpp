#pragma once
#include <optional>
#include <vector>

#include "record/chunk_contents.hpp"

namespace sinew::record {

/// The content of a file, found by reading its whole data section; the file's own summary is ignored.
struct Scan {
  Header header;
  Summary summary;                    // the summary that the file should have
  std::vector<Block> blocks;          // in the order of the file, the unreadable ones too
  std::vector<FileProblem> problems;  // in the order of the file
  std::uint64_t data_end = 0;         // where the DataEnd record is, or where reading had to stop
  std::uint32_t data_crc = 0;         // as DataEnd says; zero: not available
  bool whole = false;                 // there is a DataEnd
};

/// Never fails: missing and unreadable parts are among the problems.
Scan scan(hal::InputFile& file, const ReadLimits& limits);

}  // namespace sinew::record
