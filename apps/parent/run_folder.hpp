#pragma once
#include <string>
#include <string_view>

#include "record/run/ring_dump.hpp"

namespace sinew::app {

/// Makes a new folder UNDER/ROBOT-TIME (UTC), also for several runs within one second; empty, with `why`, on failure.
std::string make_run_folder(const std::string& under, std::string_view robot, std::string& why);

/// FOLDER/ring-N.mcap with the first free N, for a dump of the flight ring.
record::DumpFile next_ring_file(const std::string& folder);

/// An error of a file as text: "not_found: file: open (2)".
std::string error_text(const hal::Error& error);

}  // namespace sinew::app
