#pragma once
// Many results as one table: outcomes with their shares, how each measure is spread, and what went wrong.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/statistics.hpp"

namespace sinew::sweep {

/// Thread:  owner. Its memory does not grow with the number of results.
class Summary {
 public:
  static constexpr std::size_t kMostFailures = 20, kMostOutcomes = 40, kMostVariants = 40;

  /// Each result once, in the order of the cases.
  void add(const CaseResult& result);

  std::uint64_t runs() const { return runs_; }
  std::uint64_t good() const { return good_; }
  std::vector<std::string> measures() const;

  /// The table; `cases`: how many the sweep has. At most about 120 columns, but for commands.
  std::string text(std::uint64_t cases) const;
  app::Json json(std::uint64_t cases) const;

 private:
  struct Count {
    std::uint64_t runs = 0, good = 0;
  };
  struct Spread {
    Quantiles values{};
    Limits limits{};
    double worst = 0;
    CaseResult worst_in{};  // without its measures
    bool limits_differ = false;
    bool small_is_bad() const { return limits.at_least && !limits.at_most; }
  };
  struct Variant {
    Count count{};
    std::map<std::string, Quantiles> measures{};
  };
  struct Outcome {
    std::uint64_t runs = 0;
    bool good = false;
  };
  void add_measure(const MeasuredValue& measure, const CaseResult& result);
  void add_variant(const CaseResult& result);
  std::vector<std::pair<std::string, Outcome>> sorted_outcomes() const;
  std::vector<std::string> shared_parts() const;  // options that all runs have
  std::string outcome_rows() const;
  std::string measure_rows() const;
  std::string variant_rows() const;
  std::string failure_rows() const;

  std::uint64_t runs_ = 0, good_ = 0;
  std::map<std::string, Outcome> outcomes_;
  std::vector<std::string> measure_order_;
  std::map<std::string, Spread> measures_;
  std::vector<std::string> variant_order_;
  std::map<std::string, Variant> variants_;
  std::uint64_t in_other_variants_ = 0;
  std::vector<CaseResult> failures_;
};

/// Rows of cells, each column as wide as its widest cell; '<' or '>' of `align` for each column.
std::string table_text(const std::vector<std::vector<std::string>>& rows, std::string_view align);

}  // namespace sinew::sweep
