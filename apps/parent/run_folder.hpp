#pragma once
#include <string>
#include <string_view>

#include "record/run/ring_dump.hpp"

namespace sinew::app {

/// The link beside the runs that leads to the newest one.
inline constexpr const char* kLatest = "latest";

/// Makes a new folder UNDER/ROBOT-TIME (UTC), also for several runs within one second; empty, with `why`, on failure.
/// UNDER/latest is then a symbolic link to it. Where none can be made (no links on this file system, something else of
/// that name) a line on standard error says so, and the folder counts all the same.
/// Thread:  any; of two runs that begin together either one is the newest.
std::string make_run_folder(const std::string& under, std::string_view robot, std::string& why);

/// Takes back an empty folder that make_run_folder() made, for a run that did not begin: UNDER/latest then leads to the
/// newest run that is left, if there is one. A folder with files stays.
void remove_run_folder(const std::string& folder);

/// FOLDER/ring-N.mcap with the first free N, for a dump of the flight ring.
record::DumpFile next_ring_file(const std::string& folder);

/// An error of a file as text: "not_found: file: open (2)".
std::string error_text(const hal::Error& error);

}  // namespace sinew::app
