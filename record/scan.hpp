#pragma once
#include <optional>
#include <vector>

#include "record/chunk_contents.hpp"

namespace sinew::record {

/// What a file holds, found by reading all of its data section, its own summary left aside.
struct Scan {
  Header header;
  Summary summary;                    // as a summary should be
  std::vector<Block> blocks;          // in the order of the file, the unreadable ones too
  std::vector<FileProblem> problems;  // in the order of the file
  std::uint64_t data_end = 0;         // where the DataEnd record is, or where reading had to stop
  std::uint32_t data_crc = 0;         // as DataEnd has it; zero: not available
  bool whole = false;                 // there is a DataEnd
};

/// Never fails: what is not there or not readable is among the problems.
Scan scan(hal::InputFile& file, const ReadLimits& limits);

}  // namespace sinew::record
