#include "apps/run/sim_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <optional>

#include "apps/command/command.hpp"
#include "apps/flight/verdict.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/miss_cause.hpp"
#include "apps/run/plant_process.hpp"
#include "apps/run/session.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
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

hal::Duration from_ms(double ms) { return hal::Duration{static_cast<std::int64_t>(ms * 1e6)}; }

class SimulatedBoard final : public RunBoard {
 public:
  explicit SimulatedBoard(PlantProcess& plant) : plant_(plant) {}

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
    sim.late_after = from_ms(wanted.bounds.late_ms);
    sim.connect = [endpoint = plant_.endpoint()] { return hal::connect_stream(endpoint, 500ms); };
    // A plant of our own that is gone does not come back.
    if (wanted.plant != "auto") sim.relink_for = from_ms(1e3 * wanted.relink_s);
    sim.reader.fifo_priority = lockstep ? 0 : 95;  // it is this board's interrupt
    sim.reader.stack_bytes = std::size_t{64} * 1024;
    sim.on_report = [this](const std::string& json) { report_.put(json); };
    if (GroundTruthSource* const truth = find_ground_truth(run.graph()))
      sim.on_truth = [this, truth](hal::Time at, const sim_hil::Truth& state) {
        if (!truth->push(true_state(state, at))) truth_lost_.fetch_add(1, std::memory_order_relaxed);
      };
    auto board = sim_hil::SimBoard::open(plant_.take_stream(), sim, why);
    if (!board) {
      why = plant_.with_its_end(why);
      return false;
    }
    board_ = std::move(*board);
    return true;
  }

  hal::Board& devices() override { return *board_; }
  std::string problem() const override { return board_->problem(); }
  hal::GrantSource& grants() override { return *board_; }
  std::string why_no_grant(const hal::Error&) const override { return "the plant failed: " + board_->problem(); }
  std::string trouble() const override { return board_->link_trouble(); }

  bool start(RunContext& run, std::string& why) override {
    if (run.options.virtual_time || board_->start()) return true;
    why = "the plant does not start: " + board_->problem();
    return false;
  }

  bool over(RunContext& run, hal::Time now) override {
    if (!end_) end_.emplace(*run.mission);
    return end_->reached(now, report_.get()) || (!run.options.virtual_time && board_->ended());
  }

  std::string plant_report() override { return report_.get(); }

  void end() override {
    board_->bye("the runtime ended the run");
    plant_.wait_for_end();
  }

  int report(RunContext& run, RunSummary& summary) override {
    if (run.reached_s) summary.grants(board_->stats().grants, *run.reached_s, *run.wall_s);
    if (const std::uint64_t lost = truth_lost_.load(std::memory_order_relaxed); lost > 0)
      summary.add("ground truth", fmt::format("{} states lost: its thread was not run in time", lost),
                  {{"ground_truth_lost", lost}});
    const auto report = parse_report(report_.get());
    if (!report) return summary.finish("the plant sent no report", run.mission->exists() ? 1 : 0);
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
        summary.measure(in_words(m));
      }
    const RunVerdict verdict = judge(*report, *run.mission);
    if (!verdict.good) summary.why(miss_cause(evidence_of(run, *report)));
    return summary.finish(verdict.outcome, verdict.good ? 0 : 1);
  }

 private:
  static MissEvidence evidence_of(RunContext& run, const WorldReport& report) {
    MissEvidence e;
    e.report = &report;
    const msg::MissionState* const mission = run.mission->look();
    if (mission && mission->phase != msg::MissionPhase::done) e.unfinished = to_string(mission->phase);
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
    if (evidence.real_time)
      summary.add("longest IMU gap", fmt::format("{:.3f} ms", imu_gap_max_s(evidence) * 1e3),
                  {{"imu_gap_max_s", imu_gap_max_s(evidence)}});
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
  std::atomic<std::uint64_t> truth_lost_{0};
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::optional<FlightEnd> end_;
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

std::unique_ptr<hal::StopLine> open_stop_line(const std::string& plant, hal::Duration patience, std::string& why) {
  why = "it cannot be reached";
  auto stream = hal::connect_stream(plant, patience);
  if (!stream) return nullptr;
  auto line = sim_hil::SideLine::open(std::move(*stream), "parent", patience, why);
  return line ? std::move(*line) : nullptr;
}

}  // namespace

int run_on_sim(Prepared& prepared, const RunOptions& options) {
  std::string why;
  const hal::Time program = hal::program_start();  // the runtime may be a copy of it, started later
  const auto plant = open_plant(prepared, options, why);
  if (!plant) return fail(why);
  SimulatedBoard board(*plant);
  if (!needs_parent(prepared, options)) return run_session(prepared, options, board, nullptr, program);

  Supervised supervised;
  StopWay to_plant{.name = "plant", .line = open_stop_line(plant->endpoint(), 2s, why)};
  if (!to_plant.line) std::fprintf(stderr, "warning: no stop line to the plant: %s\n", why.c_str());
  // The plant may have been away and come back: the runtime survives that, an old line does not.
  to_plant.open = [&] { return open_stop_line(plant->endpoint(), 200ms, why); };
  supervised.stops.push_back(std::move(to_plant));
  supervised.body = [&](ParentLine& line) {
    plant->leave_to_parent();
    return run_session(prepared, options, board, &line, program);
  };
  supervised.in_parent = [&] { plant->leave_to_runtime(); };
  const int code = run_supervised(prepared, options, std::move(supervised));
  plant->wait_for_end();  // after a fault the plant goes on alone for a while, and its words then belong to the run
  return code;
}

}  // namespace sinew::app
