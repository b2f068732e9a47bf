#include "apps/run/session.hpp"
#include "apps/run/again.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/command/command.hpp"
#include "apps/flight/watched_grants.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/run/again.hpp"
#include "apps/run/device_stop.hpp"
#include "apps/run/device_watch.hpp"
#include "apps/run/live_view.hpp"
#include "apps/run/recording.hpp"
#include "dataset/dataset_board.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/process.hpp"
#include "hal/mixed_board.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

std::string phase_text(const RunContext& run, const msg::MissionState& state) {
  const msg::SafetyState& safety = run.mission->safety();
  const bool by_hand = run.prepared.graph->spec().guardian.arming == rt::GuardianSpec::Arming::manual;
  if (by_hand && !safety.permitted && safety.ready) return "ready: `sinew arm` lets it go";
  return phase_words(run.prepared.graph->spec(), state.phase);
}

// The history of a topic at 1 kHz may go back 50 ms only, where no period says how fast its writer is.
constexpr rt::Duration kLookPeriod = std::chrono::milliseconds(40);
constexpr std::uint32_t kLooksAView = LiveView::kPeriod / kLookPeriod;

class Session {
 public:
  Session(Prepared& prepared, const RunOptions& options, RunBoard& board, ParentLine* parent,
          std::optional<hal::Time> program)
      : program_(program),
        options_(options),
        board_(board),
        parent_(parent),
        run_{prepared, options, hal::system_os(),
             options.rate == 1 ? hal::system_os() : scaled_os_.emplace(hal::system_os(), options.rate)} {
    run_.parent = parent;
  }

  int run() {
    if (!open()) return hal::stop_requested() ? kFailed : kNotBegun;
    summary_.emplace(run_.graph(), options_.virtual_time,
                     RunSummary::Form{.json = options_.json,
                                      .quiet = options_.quiet,
                                      .verbose = options_.verbose,
                                      .strict = options_.strict,
                                      .trace = options_.trace});
    summary_->again(sweep_line(run_.prepared, options_));
    summary_->before_print([this](const RunSummary::Result& result) { end_recording(result); });
    return options_.virtual_time ? run_virtual() : run_real();
  }

 private:
  bool refuse(const std::string& why) {
    fail(why);
    return false;
  }

  bool open() {
    std::string why;
    if (!board_.open(run_, why)) return refuse(why);
    if (uses_linux_board(spec())) {
      auto real = LinuxBoard::open(run_.prepared.robot, run_.os, why);
      if (!real) return refuse(why);
      real_ = std::move(*real);
    }
    hal::Board* const own = board_named(spec().board, why);
    if (!own) return refuse(why);
    hal::MixedBoard devices(*own);
    for (const auto& [device, board] : spec().device_boards) {
      hal::Board* const other = board_named(board.value, why);
      if (!other) return refuse(fmt::format("robot.device_boards.{}: {}", device, why));
      devices.assign(device, *other);
    }
    if (!configure_on(devices) || !start_real()) return false;
    for (const std::string& device : devices.unused())
      return refuse("robot.device_boards." + device + ": no module and no actuator uses a device of this name");
    run_.mission.emplace(run_.graph());
    recording_ = Recording::open(run_.prepared, options_, run_.graph(), run_.os);
    return true;
  }

  /// Null, with `why`, when it cannot be had.
  hal::Board* board_named(const std::string& name, std::string& why) {
    if (name == board_.name()) return &board_.devices();
    if (name == "linux") return &real_->board();
    if (name != "dataset") return &none_;
    if (!recorded_) recorded_ = open_dataset(options_, options_.virtual_time ? &run_.clock : nullptr, run_.os, why);
    return recorded_.get();
  }

  bool configure_on(hal::Board& devices) {
    rt::ConfigureOptions how;
    how.os = &run_.os;
    how.taps = MissionWatch::taps(run_.graph());
    how.recorded = Recording::wanted(run_.prepared, options_);
    if (configure(run_.prepared, devices, how, [this] { return real_ ? real_->problem() : std::string(); }))
      return true;
    if (const std::string why = board_.problem(); !why.empty()) fail(why);
    return false;
  }

  bool start_real() {
    std::vector<std::string> told;
    if (real_) {
      if (auto started = real_->start(); !started) {
        real_->print_problems();
        return false;
      }
      if (!options_.quiet) real_->print_notes();
      // Before the first cycle: a run that --strict forbids must not have moved anything.
      if (!accept_shortfalls(real_->shortfalls(), options_.strict)) return false;
      told = real_->print_warnings();
    }
    complaints_ = DeviceWatch([this] { return complaints(); }, std::move(told));
    return true;
  }

  /// Complaints of real devices, and of the line to a plant, which carries all simulated devices. Thread: any.
  std::vector<std::string> complaints(bool with_silence = false) const {
    std::vector<std::string> all = real_ ? real_->complaints() : std::vector<std::string>();
    if (const std::string trouble = board_.trouble(); !trouble.empty()) all.push_back("plant: " + trouble);
    if (const std::string silence = with_silence ? board_.silence() : ""; !silence.empty())
      all.push_back("plant: " + silence);
    return all;
  }

  static int not_begun(const std::string& why) { return fail(why, hal::stop_requested() ? kFailed : kNotBegun); }

  void ended_early(double at_s) {
    run_.ended_early = hal::stop_signals() > 0 ? "interrupted" : "stopped";
    summary_->ended_early(run_.ended_early, at_s);
  }

  void end_board(hal::Time now) {
    board_.end(run_);
    for (const RunBoard::News& news : board_.news(run_, now)) add_to_story(news);
  }

  void add_to_story(const RunBoard::News& news) {
    summary_->story().add(msg::seconds(news.at - run_.begin), Story::Weight::result, news.text);
  }

  // ---- virtual time

  int run_virtual() {
    std::string why;
    if (!board_.start(run_, why)) return not_begun(why);
    WatchedGrants grants(
        board_.grants(),
        [this](hal::Time done) {
          run_.mission->look();
          return board_.over(run_, done);
        },
        &hal::stop_requested);
    rt::DiscreteOptions how;
    how.start = run_.begin;
    if (options_.duration_s > 0) how.duration = run_duration(options_);
    how.os = &run_.os;
    how.hash_topics = true;
    how.observer = observer_of(recording_);
    rt::DiscreteExecutor executor(run_.graph(), run_.clock, grants, how);
    grants.executor = &executor;
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket =
        open_socket(run_.prepared, options_, executor.runner(), recording_.get(), run_.clock, &hal::request_stop);
    const hal::Time wall = run_.system.now();
    const auto done = executor.run();
    if (!done) return fail(done.error().where);
    run_.wall_s = msg::seconds(run_.system.now() - wall);
    run_.reached_s = msg::seconds(done->reached - run_.begin);
    using End = rt::DiscreteReport::End;
    if (hal::stop_requested() && done->end != End::duration) ended_early(*run_.reached_s);
    if (!hal::stop_requested() && done->end == End::source_failed)
      summary_->lost(board_.why_no_grant(done->error), *run_.reached_s, "");
    end_board(done->reached);
    summary_->statistics(executor.runner());
    summary_->virtual_time(*run_.reached_s, *run_.wall_s);
    report_start_up(wall);
    summary_->hashes(executor.runner());
    return report();
  }

  // ---- real time

  int run_real() {
    rt::RealTimeOptions how = real_time_options(options_);
    how.runner.observer = observer_of(recording_);
    rt::RealTimeExecutor executor(run_.graph(), run_.os, how);
    const hal::ProcessUse before = hal::process_use();
    const hal::Time wall = run_.system.now();
    // Everything that may refuse to start comes before the parent watches: a run that did not begin is no fault.
    std::string why;
    if (!board_.start(run_, why)) return not_begun(why);
    if (const auto started = recorded_ ? recorded_->start() : hal::Status{}; !started)
      return fail(started.error().where);
    const auto refuse_start = [this] {
      if (parent_) parent_->ending();
      return hal::stop_requested() ? kFailed : kNotBegun;
    };
    if (!hand_to_parent(why)) {
      fail(why);
      return refuse_start();
    }
    const auto started = executor.start();
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return refuse_start();
    if (!started) {
      fail(started.error().where);
      return refuse_start();
    }
    const hal::Time first_cycle = run_.system.now();
    run_.begin = executor.started_at();
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket = open_socket(run_.prepared, options_, executor.runner(), recording_.get(), run_.os,
                                    &hal::request_stop, [this] { return complaints(true); });
    follow(executor.runner());
    const hal::MemoryUse memory = hal::memory_use();  // with the threads' stacks
    if (parent_) parent_->ending();
    executor.stop();
    const hal::ProcessUse after = hal::process_use();
    const double wall_s = msg::seconds(run_.system.now() - wall);
    if (hal::stop_requested()) ended_early(run_.lasted_s);
    end_board(run_.os.now());
    summary_->statistics(executor.runner());
    summary_->add_reasons("device", "devices", complaints_.all());
    const double processor = 100 * msg::seconds(after.cpu - before.cpu) / wall_s;
    summary_->add("processor", fmt::format("{:.1f} % of a core", processor),
                  {{"wall_s", wall_s}, {"processor_percent", processor}});
    summary_->memory(memory);
    report_start_up(first_cycle);
    for (std::uint32_t t = 0; t < run_.graph().threads().size(); ++t) {
      if (run_.graph().threads()[t].spec.name == rt::kGroundTruth) continue;  // of ordinary priority, for reports
      run_.releases += executor.runner().thread_stats(t).releases.value();
      run_.missed += executor.runner().thread_stats(t).overruns.value();
    }
    summary_->add("missed deadlines", std::to_string(run_.missed), {{"missed_deadlines", run_.missed}});
    return report();
  }

  bool hand_to_parent(std::string& why) {
    if (!parent_) return true;
    if (recording_ && recording_->ring_memory())
      if (auto kept = parent_->keep_ring(*recording_->ring_memory()); !kept) {
        why = std::string("the parent does not take the flight ring: ") + kept.error().where;
        return false;
      }
    const auto watched = parent_->supervise(*run_.graph().memory());
    if (!watched) why = std::string("the parent does not watch: ") + watched.error().where;
    return static_cast<bool>(watched);
  }

  void follow(rt::Runner& runner) {
    LiveView view(run_.graph(), runner, options_, complaints_, run_.os);
    const hal::Time begin = run_.os.now();
    std::uint32_t looks = 0;
    for (hal::Time next = begin;; next = next + kLookPeriod) {
      run_.os.sleep_until(next);
      const hal::Time now = run_.os.now();
      const auto* state = run_.mission->look();
      if (looks++ % kLooksAView != 0) continue;
      const bool ends = board_.over(run_, now) || hal::stop_requested() ||
                        (options_.duration_s > 0 && now - begin > run_duration(options_));
      std::string trouble = board_.trouble();
      if (trouble.empty()) trouble = board_.silence();
      const std::string phase = state ? phase_text(run_, *state) : "running";
      for (const RunBoard::News& news : board_.news(run_, now)) {
        view.tell(now, news.text);
        add_to_story(news);
      }
      for (const std::string& news : view.show(now, trouble.empty() ? phase : trouble, ends))
        summary_->story().add(msg::seconds(now - run_.begin), Story::Weight::result, "device  " + news);
      run_.lasted_s = msg::seconds(now - run_.begin);
      if (ends) return;
    }
  }

  /// With the result, which only the end of the summary knows.
  void end_recording(const RunSummary::Result& result) {
    if (!recording_) return;
    RunResult told{.end = result.end,
                   .outcome = result.outcome,
                   .why = result.why,
                   .exit_code = result.code,
                   .timing = result.timing};
    told.ended_s = run_.reached_s.value_or(run_.lasted_s);
    recording_->finish(*summary_, told, board_.plant_report());
  }

  int report() {
    run_.mission->look();
    for (const MissionWatch::Event& e : run_.mission->take_events())
      summary_->story().add(std::max(0.0, msg::seconds(e.at - run_.begin)), e.weight, e.text);
    return board_.report(run_, *summary_);
  }

  void report_start_up(hal::Time first_cycle) {
    if (program_) summary_->start_up(msg::seconds(first_cycle - *program_));
  }

  const rt::GraphSpec& spec() const { return run_.graph().spec(); }

  const std::optional<hal::Time> program_;
  const RunOptions& options_;
  RunBoard& board_;
  ParentLine* const parent_;
  std::optional<hal::ScaledOs> scaled_os_;
  RunContext run_;
  hal::EmptyBoard none_;
  std::unique_ptr<LinuxBoard> real_;                 // null: no real device
  std::unique_ptr<dataset::DatasetBoard> recorded_;  // for devices that the robot takes from a record
  DeviceWatch complaints_{[] { return std::vector<std::string>(); }};
  std::unique_ptr<Recording> recording_;
  std::optional<RunSummary> summary_;  // once the graph does not change any more
};

}  // namespace

std::vector<std::string> report_failsafes(RunContext& run, RunSummary& summary) {
  run.mission->look();
  std::vector<std::string> acted;
  const auto& failsafes = run.graph().spec().failsafes;
  for (std::size_t i = 0; i < failsafes.size(); ++i)
    if (run.mission->safety().acted >> i & 1) acted.push_back(failsafes[i].name + " acted");
  summary.add_reasons("failsafe", "failsafes", acted);
  return acted;
}

int run_session(Prepared& prepared, const RunOptions& options, RunBoard& board, ParentLine* parent,
                std::optional<hal::Time> program) {
  return Session(prepared, options, board, parent, program).run();
}

bool needs_parent(const Prepared& prepared, const RunOptions& options) {
  return !options.virtual_time && !options.unsupervised && !prepared.graph->spec().actuators.empty();
}

int run_supervised(Prepared& prepared, const RunOptions& options, Supervised supervised) {
  supervised.robot = prepared.graph->spec().robot;
  supervised.runs = Recording::folder_of(prepared, options);
  add_stops_of_linux_devices(prepared, supervised.stops);
  ParentOptions parent = prepared.robot.parent;
  parent.hang = hang_of(parent, prepared.graph->spec(), options.rate);
  return run_with_parent(parent, std::move(supervised));
}

}  // namespace sinew::app
