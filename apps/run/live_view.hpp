#pragma once
#include <string>

#include "apps/command/terminal.hpp"
#include "apps/run/device_watch.hpp"
#include "apps/run/run_command.hpp"
#include "apps/view/status_table.hpp"

namespace sinew::app {

/// What `sinew run` shows during a real-time run: on a terminal a table that is drawn over itself, elsewhere a line
/// from time to time, with --quiet or --json nothing. It does not wait for a blocked terminal or pipe.
/// Thread:  owner.
class LiveView {
 public:
  /// `devices`: what they complain about is shown above the table, or on a line when it changes.
  /// `clock`: the robot's.
  LiveView(const rt::Graph& graph, rt::Runner& runner, const RunOptions& options, DeviceWatch& devices,
           const hal::Clock& clock);
  /// `state` is the line above the table. Call every kPeriod; `last` for the run's end. Returns what is new about
  /// devices.
  std::vector<std::string> show(rt::Time now, std::string_view state, bool last);

  /// A line beside the table: printed where there is none.
  void tell(rt::Time now, std::string_view text);

  static constexpr rt::Duration kPeriod = std::chrono::milliseconds(200);

 private:
  const rt::Graph& graph_;
  rt::Runner& runner_;
  DeviceWatch& devices_;
  const hal::Clock& clock_;
  StatusTable table_;
  Redrawn screen_;
  const bool silent_, live_;
  rt::Time begin_ = hal::kNever;
};

}  // namespace sinew::app
