#include "apps/bare_run.hpp"

#include <cstdio>

#include "apps/live_view.hpp"
#include "apps/recording.hpp"
#include "apps/run_summary.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"
#include "rt/discrete_executor.hpp"
#include "rt/real_time_executor.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kSignalCheck = std::chrono::milliseconds(100);

// Grants in small pieces, so that a signal ends the run.
class Grants final : public hal::GrantSource {
 public:
  explicit Grants(hal::Time end) : end_(end) {}
  hal::Result<hal::Time> next_grant(hal::Time done_to) override {
    if (done_to >= end_ || hal::stop_requested()) return hal::Error{hal::Errc::closed, "end of run"};
    return std::min(end_, done_to + kSignalCheck);
  }

 private:
  hal::Time end_;
};

class BareRun {
 public:
  BareRun(Prepared& prepared, const RunOptions& options)
      : options_(options),
        prepared_(prepared),
        graph_(*prepared.graph),
        summary_(graph_, options.virtual_time, {.json = options.json, .quiet = options.quiet, .trace = options.trace}) {
  }

  int run() {
    rt::ConfigureOptions how;
    how.os = &os_;
    how.recorded = Recording::wanted(prepared_, options_);
    if (!configure(graph_, board_, how, options_)) return 2;
    recording_ = Recording::open(prepared_, options_, graph_, os_);
    return options_.virtual_time ? run_virtual() : run_real();
  }

 private:
  static int fail(const char* what) {
    std::fprintf(stderr, "sinew: %s\n", what);
    return 2;
  }

  int run_virtual() {
    const rt::Duration length = options_.duration_s > 0 ? run_duration(options_) : kBareDuration;
    Grants grants(hal::Time{length.count()});
    rt::DiscreteExecutor executor(
        graph_, clock_, grants,
        {.duration = length, .os = &os_, .hash_topics = true, .observer = observer_of(recording_)});
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket =
        open_socket(prepared_, options_, executor.runner(), recording_.get(), clock_, &hal::request_stop);
    const hal::Time wall = os_.now();
    const auto done = executor.run();
    if (!done) return fail(done.error().where);
    summary_.statistics(executor.runner());
    summary_.virtual_time(msg::seconds(done->reached), msg::seconds(os_.now() - wall));
    summary_.hashes(executor.runner());
    if (recording_) recording_->finish(summary_);
    return summary_.finish("ran to its end", 0);
  }

  int run_real() {
    rt::RealTimeOptions how = real_time_options(options_);
    how.runner.observer = observer_of(recording_);
    rt::RealTimeExecutor executor(graph_, os_, how);
    const auto started = executor.start();
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return 2;
    if (!started) return fail(started.error().where);
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket = open_socket(prepared_, options_, executor.runner(), recording_.get(), os_, &hal::request_stop);
    LiveView view(graph_, executor.runner(), options_);
    const hal::Time begin = os_.now();
    for (hal::Time next = begin;; next = next + LiveView::kPeriod) {
      os_.sleep_until(next);
      const bool ends =
          hal::stop_requested() || (options_.duration_s > 0 && os_.now() - begin > run_duration(options_));
      view.show(os_.now(), "running", ends);
      if (ends) break;
    }
    executor.stop();
    summary_.statistics(executor.runner());
    if (recording_) recording_->finish(summary_);
    return summary_.finish("ran to its end", 0);
  }

  const RunOptions& options_;
  const Prepared& prepared_;
  rt::Graph& graph_;
  hal::Os& os_ = hal::linux_os();
  hal::ManualClock clock_;
  hal::EmptyBoard board_;
  std::unique_ptr<Recording> recording_;
  RunSummary summary_;
};

}  // namespace

int run_without_devices(Prepared& prepared, const RunOptions& options) { return BareRun(prepared, options).run(); }

}  // namespace sinew::app
