#pragma once
#include "record/copy.hpp"

namespace sinew::record {

using Recovered = Copied;

/// Makes a whole file of all that can be read of another one: every complete and undamaged chunk, in order, every
/// attachment and all metadata found.
/// Errors:  those of the output file; bad_data when `from` is no MCAP file at all (`result.problems` says why).
hal::Status recover(std::unique_ptr<hal::InputFile> from, std::unique_ptr<hal::OutputFile> to, Recovered& result,
                    const ReadLimits& limits = {});

}  // namespace sinew::record
