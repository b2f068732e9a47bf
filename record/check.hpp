#pragma once
#include <vector>

#include "record/chunk_contents.hpp"

namespace sinew::record {

/// Everything that is wrong with a file, in the order in which it was found; empty: nothing. Reads the whole file:
/// every checksum, every index against its target, the statistics against the messages.
std::vector<FileProblem> check(hal::InputFile& file, const ReadLimits& limits = {});

}  // namespace sinew::record
