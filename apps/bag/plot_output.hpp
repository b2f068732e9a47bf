#pragma once
// What `bag plot` and `topic plot` share besides the fields: their options and their last step.
#include <string>
#include <vector>

#include "apps/bag/plot_fields.hpp"
#include "apps/bag/plot_marks.hpp"

namespace CLI {
class App;
}

namespace sinew::app {

struct PlotOptions {
  std::vector<std::string> fields{};
  std::vector<std::string> marked{};  // --mark
  std::string out{}, title{};
  bool no_marks = false;
};

void add_plot_options(CLI::App& app, PlotOptions& options);

/// Draws and prints what was drawn; the exit code.
int finish_plot(const PlotOptions& options, bool json, const PlotFields& fields, const PlotMarks* marks,
                const std::string& title, std::pair<double, double> range_s);

}  // namespace sinew::app
