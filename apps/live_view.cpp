#include "apps/live_view.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kLinePeriod = std::chrono::seconds(2);

}  // namespace

LiveView::LiveView(const rt::Graph& graph, rt::Runner& runner, const RunOptions& options)
    : table_(graph, runner),
      silent_(options.quiet || options.json),
      live_(!silent_ && !options.plain && hal::output_is_terminal()) {}

void LiveView::show(rt::Time now, std::string_view state, bool last) {
  if (begin_ == hal::kNever) begin_ = now;
  const rt::Duration since = now - begin_;
  const std::string line = fmt::format("{:6.1f} s  {}\n", msg::seconds(since), state);
  if (live_) {
    if (lines_ > 0) std::printf("\033[%dA", lines_);  // back to the table's first line
    lines_ = 0;
    for (const char c : line + table_.render(now, hal::terminal_columns())) {
      if (c == '\n') std::printf("\033[K"), ++lines_;
      std::putchar(c);
    }
  } else if (!silent_ && (last || since % kLinePeriod < kPeriod)) {
    std::printf("%s", line.c_str());
  }
  std::fflush(stdout);
}

}  // namespace sinew::app
