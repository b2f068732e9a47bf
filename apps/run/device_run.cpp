#include "apps/run/device_run.hpp"

#include <cstdio>

#include "apps/parent/parent.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/run/device_stop.hpp"
#include "apps/run/live_view.hpp"
#include "apps/run/recording.hpp"
#include "apps/run/run_summary.hpp"
#include "dataset/dataset_board.hpp"
#include "hal/linux/process.hpp"
#include "hal/mixed_board.hpp"
#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/real_time_executor.hpp"

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

class DeviceRun {
 public:
  /// `parent`: null when none watches.
  DeviceRun(Prepared& prepared, const RunOptions& options, ParentLine* parent)
      : options_(options),
        prepared_(prepared),
        graph_(*prepared.graph),
        parent_(parent),
        summary_(graph_, options.virtual_time, {.json = options.json, .quiet = options.quiet, .trace = options.trace}) {
  }

  int run() {
    if (uses_linux_board(graph_.spec())) {
      std::string why;
      auto real = LinuxBoard::open(prepared_.robot, os_, why);
      if (!real) return fail(why.c_str());
      real_ = std::move(*real);
    }
    rt::ConfigureOptions how;
    how.os = &os_;
    how.taps = MissionWatch::taps(graph_);
    how.recorded = Recording::wanted(prepared_, options_);
    hal::MixedBoard devices(graph_.spec().board == "linux" ? real_->board() : none_);
    if (!mix(devices)) return 2;
    if (!configure(prepared_, devices, how, options_, [this] { return real_ ? real_->problem() : std::string(); }))
      return 2;
    if (real_)
      if (auto started = real_->start(); !started) return real_->print_problems(), 2;
    if (real_ && !options_.quiet) real_->print_notes();
    // Before the first cycle: what --strict forbids to start shall not have moved anything.
    if (real_ && !accept_shortfalls(real_->shortfalls(), options_.strict)) return 2;
    if (real_) devices_ = DeviceWatch([this] { return real_->complaints(); }, real_->print_warnings());
    for (const std::string& device : devices.unused())
      return fail(("robot.device_boards." + device + ": no module and no actuator uses a device of this name").c_str());
    mission_.emplace(graph_);
    recording_ = Recording::open(prepared_, options_, graph_, os_);
    return options_.virtual_time ? run_virtual() : run_real();
  }

 private:
  static int fail(const char* what) {
    std::fprintf(stderr, "sinew: %s\n", what);
    return 2;
  }

  /// Devices with a board of their own. False after the reason was printed.
  bool mix(hal::MixedBoard& devices) {
    for (const auto& [device, board] : graph_.spec().device_boards) {
      if (board.value == "dataset" && !recorded_) {
        std::string why;
        recorded_ = open_dataset(options_, options_.virtual_time ? &clock_ : nullptr, os_, why);
        if (!recorded_) return fail(("robot.device_boards." + device + ": " + why).c_str()), false;
      }
      devices.assign(device, board.value == "linux"     ? real_->board()
                             : board.value == "dataset" ? static_cast<hal::Board&>(*recorded_)
                                                        : none_);
    }
    return true;
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
    if (parent_ && recording_ && recording_->ring_memory())
      if (auto kept = parent_->keep_ring(*recording_->ring_memory()); !kept)
        return fail("the parent does not take the flight ring");
    if (parent_)
      if (auto watched = parent_->supervise(*graph_.memory()); !watched) return fail("the parent does not watch");
    if (auto begun = recorded_ ? recorded_->start() : hal::Status{}; !begun) return fail(begun.error().where);
    const auto started = executor.start();
    const bool accepted = accept_shortfalls(executor.shortfalls(), options_.strict);
    if (!started || !accepted) {
      if (parent_) parent_->ending();
      return accepted ? fail(started.error().where) : 2;
    }
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket = open_socket(prepared_, options_, executor.runner(), recording_.get(), os_, &hal::request_stop,
                                    real_ ? [this] { return real_->complaints(); } : DeviceWatch::Ask());
    follow(executor);
    if (parent_) parent_->ending();
    executor.stop();
    summary_.statistics(executor.runner());
    if (recording_) recording_->finish(summary_);
    summary_.chains_decide(true);
    summary_.add_reasons("device", "devices", devices_.all());
    const bool acted = tell_failsafes();
    return summary_.finish(acted ? "a failsafe acted" : "ran to its end", acted ? 1 : 0);
  }

  void follow(rt::RealTimeExecutor& executor) {
    LiveView view(graph_, executor.runner(), options_, devices_);
    const hal::Time begin = os_.now();
    for (hal::Time next = begin;; next = next + LiveView::kPeriod) {
      os_.sleep_until(next);
      mission_->look();
      const bool ends = mission_->ended() || hal::stop_requested() ||
                        (options_.duration_s > 0 && os_.now() - begin > run_duration(options_));
      view.show(os_.now(), "running", ends);
      if (ends) return;
    }
  }

  /// Names those that acted in the summary; false: none.
  bool tell_failsafes() {
    mission_->look();
    std::vector<std::string> acted;
    for (std::size_t i = 0; i < graph_.spec().failsafes.size(); ++i)
      if (mission_->safety().acted >> i & 1) acted.push_back(graph_.spec().failsafes[i].name + " acted");
    summary_.add_reasons("failsafe", "failsafes", acted);
    return !acted.empty();
  }

  const RunOptions& options_;
  const Prepared& prepared_;
  rt::Graph& graph_;
  hal::Os& os_ = hal::system_os();
  hal::ManualClock clock_;
  ParentLine* const parent_;
  hal::EmptyBoard none_;
  std::unique_ptr<LinuxBoard> real_;                 // null: no device is
  std::unique_ptr<dataset::DatasetBoard> recorded_;  // of devices that are named so
  DeviceWatch devices_{[] { return std::vector<std::string>(); }};
  std::optional<MissionWatch> mission_;
  std::unique_ptr<Recording> recording_;
  RunSummary summary_;
};

}  // namespace

int run_on_devices(Prepared& prepared, const RunOptions& options) {
  if (options.virtual_time || options.unsupervised || prepared.graph->spec().actuators.empty())
    return DeviceRun(prepared, options, nullptr).run();
  Supervised supervised;
  supervised.robot = prepared.graph->spec().robot;
  supervised.runs = Recording::folder_of(prepared, options);
  add_stops_of_linux_devices(prepared, supervised.stops);
  supervised.body = [&](ParentLine& line) { return DeviceRun(prepared, options, &line).run(); };
  ParentOptions parent = prepared.robot.parent;
  parent.hang = hang_of(parent, prepared.graph->spec(), options.rate);
  return run_with_parent(parent, std::move(supervised));
}

}  // namespace sinew::app
