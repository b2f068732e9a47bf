#pragma once
// The result of comparing two versions, as a table, as JSON and as a plot.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/view/plot.hpp"
#include "record/run/comparison.hpp"

namespace sinew::app {

/// The largest relative difference first.
void sort_by_difference(std::vector<record::ComparedQuantity>& all);

/// One line for each difference, then the errors against the truth where it is known. Shows at most `most` differences
/// and counts the others. Times are seconds since `start`.
std::string comparison_table(const std::vector<record::ComparedQuantity>& sorted, rt::Time start, std::size_t most);

nlohmann::ordered_json comparison_json(const record::ComparedQuantity& q, rt::Time start);

/// Both versions over time, and the truth where it is known; one picture for each of the first `most` that differ, or
/// of all when none differs. Shows the values of numbers and the angles of attitudes.
std::vector<Plot> comparison_plots(const std::vector<record::ComparedQuantity>& sorted, std::size_t most);

}  // namespace sinew::app
