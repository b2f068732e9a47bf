#pragma once
#include <string>

#include "record/reader.hpp"

namespace sinew::app {

/// Why a recorded run has no result here; empty: it has one, or the file holds no run.
std::string why_no_result(record::Reader& reader);

/// "landed on the pad", "did not land, interrupted at 3.2 s; ...", "no result: ...": of a recorded run, in one line.
std::string result_line(record::Reader& reader);

}  // namespace sinew::app
