#pragma once
// What is told of a file of results: the table, its comparison with another file, a plot, a file for spreadsheets.
#include <cstdint>
#include <string>
#include <vector>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/results_file.hpp"

namespace sinew::app {

struct ReportOptions {
  std::string against;    // a file of earlier results; empty: none
  std::string plot;       // "MEASURE", "MEASURE:seed", "MEASURE:MODULE.PARAM"; empty: none
  std::string plot_file;  // where it goes
  std::string csv;        // where each run goes, a line each; empty: nowhere
  bool json = false;      // one object instead of the table
};

/// Told of a file and its sweep.
struct Reported {
  sweep::Identity identity{};
  sweep::Shard shard{};
  std::uint64_t runs = 0, good = 0;
  std::string text{};  // the table; with `json` the object on one line
};

/// `remark`: a last line of the table. Reads the file once for the table, and again for the plot and for --csv. Errors:
/// false, with `why`.
bool report_results(const std::string& path, const ReportOptions& options, const std::string& remark,
                    Reported& reported, std::string& why);

/// How many cases a part of a sweep has.
std::uint64_t cases_of(const sweep::Identity& identity, const sweep::Shard& shard);

}  // namespace sinew::app
