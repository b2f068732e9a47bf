#include "apps/run/live_view.hpp"

#include <fmt/format.h>

#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kLinePeriod = std::chrono::seconds(2);

}  // namespace

LiveView::LiveView(const rt::Graph& graph, rt::Runner& runner, const RunOptions& options, DeviceWatch& devices,
                   const hal::Clock& clock)
    : graph_(graph),
      runner_(runner),
      devices_(devices),
      clock_(clock),
      silent_(options.quiet || options.json),
      live_(!silent_ && !options.plain && hal::output_is_terminal()) {}

std::vector<std::string> LiveView::show(rt::Time now, std::string_view state, bool last) {
  if (begin_ == hal::kNever) begin_ = now;
  const rt::Duration since = now - begin_;
  const std::string line = fmt::format("{:6.1f} s  {}\n", msg::seconds(since), state);
  const std::vector<std::string> news = devices_.look(now);
  if (live_) {
    std::string devices;
    for (const std::string& complaint : devices_.now()) devices += "  device  " + complaint + "\n";
    // Not `now`: between the two a busy machine may have taken the processor away for long.
    const StatusRows rows = rows_of(graph_, runner_);
    const std::string table = table_.render(rows, clock_.now(), hal::terminal_columns());
    hal::print_now(screen_.over(line + devices + table, hal::terminal_rows()));
    return news;
  }
  if (silent_) return news;
  for (const std::string& text : news)
    hal::print_now(fmt::format("{:6.1f} s  device  {}\n", msg::seconds(since), text));
  if (last || since % kLinePeriod < kPeriod) hal::print_now(line);
  return news;
}

void LiveView::tell(rt::Time now, std::string_view text) {
  if (begin_ == hal::kNever) begin_ = now;
  if (!live_ && !silent_) hal::print_now(fmt::format("{:6.1f} s  {}\n", msg::seconds(now - begin_), text));
}

}  // namespace sinew::app
