#include "apps/run/sim_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <optional>
#include <utility>

#include "apps/command/command.hpp"
#include "apps/flight/verdict.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/miss_cause.hpp"
#include "apps/run/plant_process.hpp"
#include "apps/run/session.hpp"
#include "hal/linux/priority_mutex.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "hal/wide.hpp"
#include "sim_hil/board/side_line.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

// The plant's latest report; written by the receiving thread.
class ReportBox {
 public:
  void put(const std::string& json) {
    const std::lock_guard lock(mutex_);
    json_ = json;
  }
  std::string get() {
    const std::lock_guard lock(mutex_);
    return json_;
  }

 private:
  std::mutex mutex_;
  std::string json_;
};

/// Times in which a plant said nothing, while somebody waits for it: told while they last, and when they are over.
/// Thread:  owner.
class SilenceWatch {
 public:
  explicit SilenceWatch(PlantProcess& plant) : plant_(plant) {}

  /// "no grant from the simulator for 5 s; it is stopped": the first time after kLong, then ever more seldom. Empty:
  /// not yet, or told already. `what`: what does not come.
  std::string lasts(const char* what, hal::Duration silent) {
    if (silent < next_tell_) return {};
    next_tell_ = 4 * silent;
    told_ = true;
    return words(what, silent);
  }
  /// "the simulator goes on after 7.3 s", once; empty: nothing was told.
  std::string over(hal::Duration silent) {
    next_tell_ = kLong;
    if (!std::exchange(told_, false)) return {};
    return fmt::format("the simulator goes on after {:.1f} s", msg::seconds(silent));
  }
  std::string words(const char* what, hal::Duration silent) const {
    return fmt::format("no {} from the simulator for {} s; {}; Ctrl-C ends the run", what, silent / 1s,
                       plant_.is_stopped() ? "it is stopped" : "it does not answer");
  }

  static constexpr hal::Duration kLong = 5s;

 private:
  PlantProcess& plant_;
  hal::Duration next_tell_ = kLong;
  bool told_ = false;
};

/// How long a plant of our own may take to end; part of the two seconds in which a signal ends a run.
hal::Duration plant_ends_within() { return hal::stop_requested() ? hal::Duration(1s) : hal::Duration(3s); }

hal::Duration from_ms(double ms) { return hal::Duration{static_cast<std::int64_t>(ms * 1e6)}; }

class SimulatedBoard final : public RunBoard {
 public:
  explicit SimulatedBoard(PlantProcess& plant) : plant_(plant), silence_(plant) {}

  std::string name() const override { return "sim"; }

  bool open(RunContext& run, std::string& why) override {
    const SimTable& wanted = run.prepared.robot.sim;
    const bool lockstep = run.options.virtual_time;
    sim_hil::SimBoardOptions sim;
    sim.mode = lockstep ? sim_hil::Mode::lockstep : sim_hil::Mode::free_running;
    sim.robot = run.graph().spec().robot;
    sim.seed = world_seed(run.prepared.robot);
    sim.clock = &run.robot_clock();
    sim.os = &run.system;
    sim.rate = run.options.rate;
    // A plant of our own may still set up its camera. Virtual time has no deadline, and a busy machine may take long.
    sim.patience = lockstep ? 60s : 20s;
    sim.silence.go_on = [this](hal::Duration silent) { return go_on(silent); };
    sim.silence.over = [this, clock = &run.robot_clock()](hal::Duration silent) {
      const std::string text = silence_.over(silent);
      say(text);
      if (!text.empty() && board_) news_.push_back({clock->now(), text});
    };
    sim.late_after = from_ms(wanted.bounds.late_ms);
    sim.connect = [endpoint = plant_.endpoint()] { return hal::connect_stream(endpoint, 500ms); };
    if (!lockstep)
      if (auto lock = hal::priority_mutex()) sim.send_lock = std::move(*lock);
    // A plant of our own that is gone does not come back.
    if (wanted.plant != "auto") sim.relink_for = from_ms(1e3 * wanted.relink_s);
    sim.reader.fifo_priority = lockstep ? 0 : 95;  // it is this board's interrupt
    sim.reader.stack_bytes = std::size_t{64} * 1024;
    sim.on_report = [this](const std::string& json) { report_.put(json); };
    if (GroundTruthSource* const truth = find_ground_truth(run.graph()))
      sim.on_truth = [this, truth](hal::Time at, const sim_hil::Truth& state) {
        if (!truth->push(true_state(state, at))) truth_lost_.add();
      };
    auto board = sim_hil::SimBoard::open(plant_.take_stream(), sim, why);
    if (!board) {
      why = hal::stop_requested() ? "interrupted while the simulator started" : plant_.with_its_end(why);
      return false;
    }
    board_ = std::move(*board);
    waits_for_ = "grant";
    return true;
  }

  hal::Board& devices() override { return *board_; }
  std::string problem() const override { return board_->problem(); }
  hal::GrantSource& grants() override { return *board_; }
  std::string why_no_grant(const hal::Error&) const override { return "the plant failed: " + board_->problem(); }
  std::string trouble() const override { return board_->link_trouble(); }

  bool start(RunContext& run, std::string& why) override {
    if (run.options.virtual_time) {
      const auto first = board_->begin();
      if (first) run.begin = *first;
      if (first) return true;
    } else if (board_->start()) {
      return true;
    }
    why = hal::stop_requested() ? "interrupted while the simulator started"
                                : plant_.with_its_end("the plant does not start: " + board_->problem());
    return false;
  }

  bool over(RunContext& run, hal::Time now) override {
    if (!end_) end_.emplace(*run.mission);
    if (!run.parent) plant_.look();
    return end_->reached(now, report_.get()) || (!run.options.virtual_time && board_->ended());
  }

  std::string silence() const override {
    const hal::Duration silent = board_->silent_for();
    return silent < SilenceWatch::kLong ? std::string() : silence_.words("samples", SilenceWatch::kLong);
  }

  std::vector<News> news(RunContext& run, hal::Time now) override {
    if (!run.options.virtual_time) {
      const hal::Duration silent = board_->silent_for();
      if (const std::string text = silence_.lasts("samples", silent); !text.empty()) news_.push_back({now, text});
      if (silent < longest_silent_)
        if (const std::string text = silence_.over(longest_silent_); !text.empty()) news_.push_back({now, text});
      longest_silent_ = silent;
    }
    return std::exchange(news_, {});
  }

  std::string plant_report() override { return report_.get(); }

  void end(RunContext& run) override {
    if (board_->ended() && !board_->ended_politely()) lost_ = how_it_was_lost(run);
    if (hal::stop_requested()) lost_.reset();  // a signal to all processes of the run ends the plant, too
    board_->bye(hal::stop_requested() ? "the run was interrupted" : "the runtime ended the run");
    say(plant_.wait_for_end(plant_ends_within()));
    last_report_ = plant_.last_report();
  }

  int report(RunContext& run, RunSummary& summary) override {
    if (run.reached_s && *run.reached_s > 0) summary.grants(board_->stats().grants, *run.reached_s, *run.wall_s);
    if (const std::uint64_t lost = truth_lost_.value(); lost > 0)
      summary.add("ground truth", fmt::format("{} states lost: its thread was not run in time", lost),
                  {{"ground_truth_lost", lost}});
    const auto report = parse_report(report_.get());
    if (lost_) summary.lost(lost_->what, lost_->at_s, lost_->why);
    pass_on_report(summary);
    if (!report) {
      const char* const outcome = lost_ || hal::stop_requested() ? "" : "the plant sent no report";
      return summary.finish(outcome, run.mission->exists() ? 1 : 0);
    }
    std::vector<std::string> faults;
    for (const auto& f : report->faults) {
      faults.push_back(fmt::format("{}: struck {} times", f.text, f.affected));
      if (f.first_s) summary.story().add(*f.first_s, Story::Weight::result, "fault " + faults.back());
    }
    summary.add_reasons("fault", "faults", faults);
    report_failsafes(run, summary);
    if (const hal::Time disarmed = run.mission->safety().disarmed; disarmed.ns != 0) {
      const double at_s = msg::seconds(disarmed - run.begin);
      summary.add("disarmed", fmt::format("after {:.2f} s, while the actuators were live", at_s),
                  {{"disarmed_s", at_s}});
    }
    summary.chains_decide(report->faults.empty());  // with a broken device a chain may well be late
    report_validity(run, *report, summary);
    if (report->verdict)
      for (const WorldReport::Measure& m : report->verdict->measures) {
        summary.add(m.label, to_string(m), {{m.key, m.value}});
        summary.measure(m);
      }
    const RunVerdict verdict = judge(*report, *run.mission);
    if (!verdict.good) summary.why(miss_cause(evidence_of(run, *report)));
    return summary.finish(verdict.outcome, verdict.good ? 0 : 1);
  }

 private:
  struct Lost {
    std::string what, why;
    double at_s = 0;
  };

  /// Puts the simulator's report into the object, with all that its world reports. A plant of our own has left its last
  /// one also where the connection was lost.
  void pass_on_report(RunSummary& summary) {
    const Json said = Json::parse(last_report_.empty() ? report_.get() : last_report_, nullptr, false);
    if (said.is_object()) summary.keep({{"report", said}});
  }

  /// While the board waits for the plant, on the thread that runs the session.
  bool go_on(hal::Duration silent) {
    if (hal::stop_requested()) return false;
    plant_.look();
    say(silence_.lasts(waits_for_, silent));
    return true;
  }

  static void say(const std::string& text) {
    if (!text.empty()) std::fprintf(stderr, "sinew: %s\n", text.c_str());
  }

  Lost how_it_was_lost(RunContext& run) {
    // A peer often sees the connection close before the process that closed it has ended.
    const auto exit = plant_.ended(500ms);
    const double at_s = msg::seconds(board_->ended_at() - run.begin);
    if (exit && exit->code != 0)
      return {"the simulator " + to_string(*exit),
              hal::describe_exit(exit->code) + (exit->words.empty() ? "" : "; its last words: " + exit->words), at_s};
    if (plant_.own() && run.parent && run.parent->is_gone())
      return {"the parent process died, and the simulator with it", "", at_s};
    if (board_->silent()) return {"the simulator fell silent", board_->end_reason(), at_s};
    return {"the simulator closed the connection", board_->end_reason(), at_s};
  }

  static MissEvidence evidence_of(RunContext& run, const WorldReport& report) {
    MissEvidence e;
    e.report = &report;
    const msg::MissionState* const mission = run.mission->look();
    if (mission && mission->phase != msg::MissionPhase::done)
      e.unfinished = phase_words(run.graph().spec(), mission->phase);
    e.ended_early = run.ended_early;
    e.ended_s = run.reached_s.value_or(run.lasted_s);
    for (std::size_t i = 0; i < run.graph().spec().failsafes.size(); ++i)
      if (run.mission->safety().acted >> i & 1) e.failsafes.push_back(run.graph().spec().failsafes[i].name);
    if (!run.graph().spec().actuators.empty()) e.saturated = run.mission->saturated();
    e.estimate = run.mission->estimate_error();
    e.real_time = !run.options.virtual_time;
    e.frames_late_percent_bound = run.prepared.robot.sim.bounds.frames_late_percent;
    return e;
  }

  /// Each measurement with its bound, and why the run does not count as a measurement.
  void report_validity(RunContext& run, const WorldReport& report, RunSummary& summary) const {
    RunEvidence evidence;
    evidence.real_time = !run.options.virtual_time;
    evidence.rate = run.options.rate;
    evidence.plant = report;
    evidence.board = board_->stats();
    evidence.releases = run.releases;
    evidence.missed = run.missed;
    const auto findings = examine(evidence, run.prepared.robot.sim.bounds);
    Json validity = Json::array();
    for (const Finding& f : findings)
      validity.push_back(
          {{"bound", f.key}, {"what", f.what}, {"value", f.value}, {"most", f.bound}, {"holds", f.holds}});
    if (evidence.real_time) {
      summary.add("longest IMU gap", fmt::format("{:.3f} ms", imu_gap_max_s(evidence) * 1e3),
                  {{"imu_gap_max_s", imu_gap_max_s(evidence)}});
      summary.keep({{"world_offset_s", msg::seconds(evidence.board.clock_offset)}});
    }
    if (evidence.board.remote) {
      const sim_hil::ClockStats& c = evidence.board.clock;
      summary.add("clock of the plant",
                  fmt::format("known to {:.3f} ms, drift {:+.1f} ppm, {} exchanges", 1e3 * msg::seconds(c.worst_bound),
                              1e6 * c.drift, c.exchanges),
                  {{"clock_offset_s", msg::seconds(c.offset)},
                   {"clock_bound_s", msg::seconds(c.worst_bound)},
                   {"clock_drift_ppm", 1e6 * c.drift},
                   {"clock_exchanges", c.exchanges}});
    }
    TimingVerdict timing{.reasons = invalid_because(findings)};
    if (const Finding* const worst = worst_of(findings)) {
      timing.worst = worst->key == "plant" ? worst->what : fmt::format("{} (at most {:g})", worst->what, worst->bound);
      timing.what_to_do = what_to_do(*worst, evidence.real_time, run.options.robot);
    }
    summary.timing(std::move(timing));
    summary.keep({{"validity", validity}});
  }

  PlantProcess& plant_;
  ReportBox report_;
  std::string last_report_;  // of a plant of our own that has ended
  hal::Tally truth_lost_;
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::optional<FlightEnd> end_;
  SilenceWatch silence_;
  const char* waits_for_ = "answer";
  std::vector<News> news_;
  hal::Duration longest_silent_{0};  // real time: as of the last look
  std::optional<Lost> lost_;
};

std::unique_ptr<PlantProcess> open_plant(const Prepared& prepared, const RunOptions& options, std::string& why) {
  const SimTable& sim = prepared.robot.sim;
  PlantRequest request;
  request.endpoint = sim.plant;
  request.world = sim.world;
  request.seed = world_seed(prepared.robot);
  request.camera_width = sim.camera_width;
  request.camera_height = sim.camera_height;
  request.lockstep = options.virtual_time;
  request.extra = world_arguments(sim);
  request.extra.insert(request.extra.end(), options.plant_args.begin(), options.plant_args.end());
  if (!options.faults.empty() && request.endpoint != "auto") {
    why = "--fault: only a plant that this run starts itself (plant \"auto\") plays faults";
    return nullptr;
  }
  // The plant itself plays faults of its drives on a bus, whatever board the robot reaches the joints by.
  const bool drives = std::ranges::find(options.plant_args, "--servo") != options.plant_args.end();
  for (const std::string& fault : options.faults)
    if (why = unfelt_fault(prepared.graph->spec(), fault); !why.empty() && !(drives && fault.starts_with("joints:")))
      return nullptr;
  for (const std::string& fault : options.faults) request.extra.insert(request.extra.end(), {"--fault", fault});
  return PlantProcess::open(request, why);
}

/// Where several robots share the plant, a line in the name of one stops that one.
std::unique_ptr<hal::StopLine> open_stop_line(const std::string& plant, const std::string& robot,
                                              hal::Duration patience, std::string& why) {
  why = "it cannot be reached";
  auto stream = hal::connect_stream(plant, patience);
  if (!stream) return nullptr;
  auto line = sim_hil::SideLine::open(std::move(*stream), robot, patience, why);
  return line ? std::move(*line) : nullptr;
}

}  // namespace

int run_on_sim(Prepared& prepared, const RunOptions& options) {
  std::string why;
  const hal::Time program = hal::program_start();  // the runtime may be a copy of it, started later
  const auto plant = open_plant(prepared, options, why);
  if (!plant) return fail(why, hal::stop_requested() ? kFailed : kNotBegun);
  SimulatedBoard board(*plant);
  if (options.virtual_time) plant->hide();  // in real time other connections are still to come
  if (!needs_parent(prepared, options)) return run_session(prepared, options, board, nullptr, program);

  const std::string& robot = prepared.graph->spec().robot;
  Supervised supervised;
  StopWay to_plant{.name = "plant", .line = open_stop_line(plant->endpoint(), robot, 1s, why)};
  if (!to_plant.line) std::fprintf(stderr, "warning: no stop line to the plant: %s\n", why.c_str());
  // The plant may have been away and come back: the runtime survives that, an old line does not.
  to_plant.open = [&] { return open_stop_line(plant->endpoint(), robot, 200ms, why); };
  to_plant.needless = [&] {
    plant->look();
    if (plant->is_stopped()) return std::string("not needed: the simulator is stopped, and is killed");
    return plant->ended(0s) ? std::string("not needed: the simulator has ended") : std::string();
  };
  // A plant of our own does not come back: it needs its address no more.
  if (to_plant.line) plant->hide();
  supervised.stops.push_back(std::move(to_plant));
  supervised.look = [&] { plant->look(); };
  supervised.body = [&](ParentLine& line) {
    plant->leave_to_parent();
    return run_session(prepared, options, board, &line, program);
  };
  supervised.in_parent = [&] { plant->leave_to_runtime(); };
  const int code = run_supervised(prepared, options, std::move(supervised));
  // After a fault the plant goes on alone for a while, and its words then belong to the run.
  if (const std::string why_killed = plant->wait_for_end(plant_ends_within()); !why_killed.empty())
    std::fprintf(stderr, "sinew: %s\n", why_killed.c_str());
  return code;
}

}  // namespace sinew::app
