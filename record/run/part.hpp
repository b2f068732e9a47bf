#pragma once
#include <span>

#include "record/copy.hpp"

namespace sinew::record {

/// For a copy of what a run has from `from` on (log time): it begins in the middle of the run, and says where; it has
/// the requests of before, too, since parameters that they set still hold. Nothing of files without a run.
CopyChanges changes_of_cut(Reader& reader, std::uint64_t from);

/// For one file of several: it begins where the earliest of them does.
CopyChanges changes_of_merge(std::span<Reader* const> readers);

}  // namespace sinew::record
