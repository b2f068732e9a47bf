// top: a running robot, again and again.
#include <cstdio>

#include "apps/command/number_check.hpp"
#include "apps/command/terminal.hpp"
#include "apps/live/commands.hpp"
#include "apps/live/live_command.hpp"
#include "apps/live/status_text.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

struct TopOptions : LiveOptions {
  bool once = false;
  double period_s = 0.5;
};

int top(const TopOptions& options) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  hal::Os& os = hal::system_os();
  const rt::Duration period{static_cast<std::int64_t>(options.period_s * 1e9)};
  const bool redraw = hal::output_is_terminal() && !options.once && !options.json;
  StatusTable table;
  Redrawn screen;
  // Rates need two looks: with --once only the second look is shown.
  for (int look = 0; !hal::stop_requested(); ++look, os.sleep_until(os.now() + period)) {
    const auto status = robot->ask("status");
    if (!status) return kFailed;
    const rt::Time now{status->value("now_ns", std::int64_t{0})};
    const std::string text =
        robot->name() + "\n" + table.render(rows_of(*status), now, redraw ? hal::terminal_columns() : 0);
    const bool shown = !options.once || look == 1;
    if (options.json && shown)
      std::printf("%s", to_line(*status).c_str());
    else if (redraw)
      std::printf("%s", screen.over(text, hal::terminal_rows()).c_str());
    else if (shown)
      std::printf("%s", text.c_str());
    std::fflush(stdout);
    if (options.once && look == 1) break;
  }
  return kDone;
}

}  // namespace

void add_top_command(CLI::App& app, CommandContext& context) {
  auto command = live_command(app, context, "top",
                              "threads and topics of a running robot, again and again; rates in its time", top);
  command.app.add_flag("--once", command.options.once, "print only one table, with the rates of one period");
  command.app.add_option("--period", command.options.period_s, "how often")
      ->check(number(0.05, 3600.0))
      ->type_name("S");
}

}  // namespace sinew::app
