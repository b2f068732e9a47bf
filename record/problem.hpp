#pragma once
#include <cstdint>
#include <string>

namespace sinew::record {

/// What can be wrong with a file.
enum class ProblemKind : std::uint8_t {
  not_mcap,         // no magic bytes, or of another major version
  truncated,        // the file ends inside a record, or before its summary
  bad_record,       // its fields do not fit into it, or contradict each other
  bad_checksum,     // the bytes are not those that were written
  bad_compression,  // unknown, or the frame is damaged
  unknown_channel,  // a message or a channel refers to something that was not defined before
  bad_index,        // the summary or an index contradicts the data
  too_large,        // beyond the reader's limits
  io,               // the system refused
};
const char* to_string(ProblemKind kind);

/// A problem: its kind, its place, and what would be right.
struct FileProblem {
  ProblemKind kind = ProblemKind::io;
  std::uint64_t offset = 0;  // in the file
  std::string text;
};
std::string to_string(const FileProblem& problem);  // "offset 4711: bad checksum: ..."

}  // namespace sinew::record
