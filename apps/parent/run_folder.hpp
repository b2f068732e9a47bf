#pragma once
#include <string>
#include <string_view>

#include "record/run/ring_dump.hpp"

namespace sinew::app {

/// A new folder UNDER/ROBOT-TIME (UTC) of its own, also for several within one second; empty, with `why`, when there
/// can be none.
std::string make_run_folder(const std::string& under, std::string_view robot, std::string& why);

/// FOLDER/ring-N.mcap, the first that there is not yet, for a dump of the flight ring.
record::DumpFile next_ring_file(const std::string& folder);

/// What went wrong with a file, in words: "not_found: file: open (2)".
std::string error_text(const hal::Error& error);

}  // namespace sinew::app
