#include "apps/run/device_run.hpp"

#include <algorithm>

#include "apps/run/session.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kSignalCheck = std::chrono::milliseconds(100);

/// Real devices, or none: the session itself opens those of the board "linux".
class BareBoard final : public RunBoard, private hal::GrantSource {
 public:
  std::string name() const override { return "none"; }
  bool open(RunContext& run, std::string&) override {
    end_ = hal::Time{(run.options.duration_s > 0 ? run_duration(run.options) : kBareDuration).count()};
    return true;
  }
  hal::Board& devices() override { return none_; }
  hal::GrantSource& grants() override { return *this; }
  bool over(RunContext& run, hal::Time) override { return !run.options.virtual_time && run.mission->ended(); }

  int report(RunContext& run, RunSummary& summary) override {
    if (run.options.virtual_time) return summary.finish(hal::stop_requested() ? "" : "ran to its end", 0);
    summary.chains_decide(true);
    const std::vector<std::string> acted = report_failsafes(run, summary);
    if (acted.empty()) return summary.finish(hal::stop_requested() ? "" : "ran to its end", 0);
    summary.why("failsafe " + acted.front());
    return summary.finish("a failsafe acted", 1);
  }

 private:
  // In small pieces, so that a signal ends the run.
  hal::Result<hal::Time> next_grant(hal::Time done_to) override {
    if (done_to >= end_ || hal::stop_requested()) return hal::Error{hal::Errc::closed, "end of run"};
    return std::min(end_, done_to + kSignalCheck);
  }

  hal::EmptyBoard none_;
  hal::Time end_{};
};

}  // namespace

int run_on_devices(Prepared& prepared, const RunOptions& options) {
  BareBoard board;
  if (!needs_parent(prepared, options)) return run_session(prepared, options, board, nullptr, hal::program_start());
  const hal::Time program = hal::program_start();
  Supervised supervised;
  supervised.body = [&](ParentLine& line) { return run_session(prepared, options, board, &line, program); };
  return run_supervised(prepared, options, std::move(supervised));
}

}  // namespace sinew::app
