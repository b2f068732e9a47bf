#include "record/problem.hpp"

namespace sinew::record {

const char* to_string(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::not_mcap:
      return "not an MCAP file";
    case ProblemKind::truncated:
      return "cut off";
    case ProblemKind::bad_record:
      return "bad record";
    case ProblemKind::bad_checksum:
      return "bad checksum";
    case ProblemKind::bad_compression:
      return "bad compression";
    case ProblemKind::unknown_channel:
      return "unknown channel";
    case ProblemKind::bad_index:
      return "bad index";
    case ProblemKind::too_large:
      return "too large";
    case ProblemKind::io:
      return "cannot be read";
  }
  return "?";
}

std::string to_string(const FileProblem& problem) {
  return "offset " + std::to_string(problem.offset) + ": " + to_string(problem.kind) + ": " + problem.text;
}

}  // namespace sinew::record
