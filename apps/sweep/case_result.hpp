#pragma once
// What one line of a file of results says.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/command/json.hpp"

namespace sinew::sweep {

struct Limits {
  std::optional<double> at_most{}, at_least{};
  bool operator==(const Limits&) const = default;
};
/// "at most 0.15"; empty: none.
std::string to_string(const Limits& limits);

struct MeasuredValue {
  std::string name;  // with its unit: "landing_error_m"
  double value = 0;
  Limits limits{};
  bool within() const {
    return !(limits.at_most && value > *limits.at_most) && !(limits.at_least && value < *limits.at_least);
  }
};

struct CaseResult {
  std::uint64_t number = 0;
  std::string run;  // options of the command that repeats it: of `sinew run`, or "match" and those of `sinew match`
  int code = 0;
  bool good = false;
  std::string outcome, why;  // in words; `why` is empty where it is good
  std::string hash;          // of all that it published; empty: not known
  std::vector<MeasuredValue> measures;
  app::Json report{};  // what the world said about the run beyond that, an object; null: nothing
};

/// Keys that are missing or of another type keep their defaults.
CaseResult case_result(std::uint64_t number, const app::Json& line);
/// The object that ResultsFile::append() takes; without the number.
app::Json to_json(const CaseResult& result);

/// The command that repeats it.
std::string repeat_command(const std::string& run);

}  // namespace sinew::sweep
