#include "apps/bag/run_text.hpp"

#include "record/run/run_sink.hpp"

namespace sinew::app {

std::string why_no_result(record::Reader& reader) {
  if (!read_metadata(reader, record::kResultName).empty() || read_metadata(reader, "sinew.run").empty()) return {};
  if (!read_metadata(reader, "sinew.dump").empty()) return "a dump of the flight ring, written while the run went on";
  if (!reader.by_summary()) return "the file has no end: its process was killed, or lost its power";
  if (read_metadata(reader, "sinew.verdict").empty())
    return "a later part of this recording has it, or its process was killed";
  return "recorded by a version of sinew that did not write it";
}

std::string result_line(record::Reader& reader) {
  if (const std::string why = why_no_result(reader); !why.empty()) return "no result: " + why;
  const auto result = read_metadata(reader, record::kResultName);
  const auto text = [&](const char* key) {
    const auto found = result.find(key);
    return found == result.end() ? std::string() : found->second;
  };
  const std::string outcome = text("outcome"), end = text("end"), why = text("why");
  // "ended" is "over" in older recordings; what else ended a run is most often in its outcome, with the time.
  const bool over = end == "over" || end == "ended" || outcome.find(end) != std::string::npos;
  std::string line = outcome.empty() || !over ? end : outcome;
  if (!outcome.empty() && !over) line += ": " + outcome;
  return why.empty() ? line : line + "; " + why;
}

}  // namespace sinew::app
