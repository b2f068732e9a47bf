#pragma once
// What a comparison of two versions found, as a table, as JSON and as a plot.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "record/run/comparison.hpp"

namespace sinew::app {

/// The largest relative difference first.
void sort_by_difference(std::vector<record::ComparedQuantity>& all);

/// A line each, differences first, then what there is of the truth. Of more than `most` that differ the others are
/// counted. Times are seconds since `start`.
std::string comparison_table(const std::vector<record::ComparedQuantity>& sorted, rt::Time start, std::size_t most);

nlohmann::ordered_json comparison_json(const record::ComparedQuantity& q, rt::Time start);

/// Both versions over time, and the truth where there is one; one picture for each of the first `most` that differ, or
/// of all when none does. Of numbers the values, of attitudes the angles.
std::string comparison_plot(const std::vector<record::ComparedQuantity>& sorted, std::size_t most);

}  // namespace sinew::app
