#pragma once
#include "record/reader.hpp"

namespace sinew::record {

struct Recovered {
  std::uint64_t messages = 0, attachments = 0, metadata = 0;
  std::vector<Problem> problems;  // what could not be kept, and why
};

/// Makes a whole file of all that can be read of another one: every chunk that is complete and undamaged, in its order,
/// every attachment and all metadata that are found.
/// Errors:  those of the output file; bad_data when `from` is no MCAP file at all (`result.problems` says why).
hal::Status recover(std::unique_ptr<hal::InputFile> from, std::unique_ptr<hal::OutputFile> to, Recovered& result,
                    const ReadLimits& limits = {});

}  // namespace sinew::record
