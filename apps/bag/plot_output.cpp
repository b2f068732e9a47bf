#include "apps/bag/plot_output.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "apps/command/command.hpp"
#include "apps/command/json.hpp"

namespace sinew::app {
namespace {

Json series_json(const Plot& plot, const Series& series) {
  double low = 0, high = 0;
  std::size_t count = 0;
  for (const auto& [t, v] : series.points) {
    if (v != v) continue;
    low = count == 0 ? v : std::min(low, v);
    high = count == 0 ? v : std::max(high, v);
    ++count;
  }
  Json json{{"name", series.name}, {"unit", plot.y_label}, {"points", count}};
  if (count > 0) json["min"] = low, json["max"] = high;
  return json;
}

}  // namespace

void add_plot_options(CLI::App& app, PlotOptions& options) {
  app.add_option("fields", options.fields,
                 "TOPIC.FIELD, 'FIELD - FIELD', 'angle(FIELD, FIELD)' of two attitudes, 'norm(FIELD)'")
      ->required()
      ->type_name(kFieldHint);
  app.add_option("-o,--out", options.out, "FILE.svg or FILE.png; an older one is replaced")
      ->required()
      ->check(&why_no_plot_file)
      ->type_name(kFileHint);
  app.add_option("--title", options.title, "above the plot");
  app.add_option("--mark", options.marked, "mark each change of this field, too; may be given again")
      ->type_name(kFieldHint)
      ->allow_extra_args(false);
  app.add_flag("--no-marks", options.no_marks, "no phases, failsafes and requests");
}

int finish_plot(const PlotOptions& options, bool json, const PlotFields& fields, const PlotMarks* marks,
                const std::string& title, std::pair<double, double> range_s) {
  std::vector<Plot> plots = fields.plots();
  const auto all = marks ? marks->marks() : std::vector<PlotMark>();
  for (Plot& plot : plots) {
    plot.x_range = range_s;
    plot.marks = all;
    if (&plot != plots.data())
      for (PlotMark& mark : plot.marks) mark.text.clear();  // the first one has them
  }
  plots.front().title = options.title.empty() ? title : options.title;
  plots.back().x_label = "time (s)";
  if (const std::string why = write_plots(options.out, plots); !why.empty()) return fail(why, kFailed);
  Json drawn = Json::array(), happened = Json::array();
  std::size_t without = 0;
  for (const Plot& plot : plots)
    for (const Series& series : plot.series) {
      drawn.push_back(series_json(plot, series));
      without += drawn.back()["points"] == 0 ? 1 : 0;
    }
  for (const PlotMark& mark : all)
    if (mark.x >= range_s.first && mark.x <= range_s.second)
      happened.push_back({{"time_s", mark.x}, {"text", mark.text}, {"alarm", mark.alarm}});
  if (json)
    std::printf("%s", to_line({{"file", options.out}, {"series", drawn}, {"marks", happened}}).c_str());
  else
    std::printf("%s: %zu curves, %zu marks\n", options.out.c_str(), drawn.size(), happened.size());
  return without == 0 ? kDone : fail(fmt::format("{} of {} curves have no values", without, drawn.size()), kFailed);
}

}  // namespace sinew::app
