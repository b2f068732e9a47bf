#include "apps/run/sim_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <optional>

#include "apps/parent/parent.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot_file/flight_report.hpp"
#include "apps/run/device_stop.hpp"
#include "apps/run/live_view.hpp"
#include "apps/run/plant_process.hpp"
#include "apps/run/recording.hpp"
#include "apps/run/run_summary.hpp"
#include "dataset/dataset_board.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/mixed_board.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/real_time_executor.hpp"
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

class SimRun {
 public:
  /// `parent`: null when none watches. `program`: when it was started; nothing when that is unknown.
  SimRun(Prepared& prepared, const RunOptions& options, PlantProcess& plant, ParentLine* parent,
         std::optional<hal::Time> program)
      : program_(program),
        options_(options),
        prepared_(prepared),
        robot_(prepared.robot),
        graph_(*prepared.graph),
        os_(options.rate == 1 ? real_os_ : scaled_os_.emplace(real_os_, options.rate)),
        plant_(plant),
        parent_(parent),
        summary_(graph_, options.virtual_time, {.json = options.json, .quiet = options.quiet, .trace = options.trace}) {
  }

  int run() {
    if (!open()) return 2;
    return options_.virtual_time ? run_virtual() : run_real();
  }

 private:
  bool fail(const std::string& what) {
    std::fprintf(stderr, "sinew: %s\n", what.c_str());
    return false;
  }

  bool open() {
    std::string why;
    sim_hil::SimOptions sim;
    sim.mode = options_.virtual_time ? sim_hil::Mode::lockstep : sim_hil::Mode::free_running;
    sim.robot = graph_.spec().robot;
    sim.seed = graph_.spec().seed;
    sim.clock = options_.virtual_time ? static_cast<const hal::Clock*>(&clock_) : &os_;
    sim.os = &real_os_;
    sim.rate = options_.rate;
    // A plant of our own may still set up its camera; in virtual time nobody waits, and a busy machine may take long.
    sim.patience = options_.virtual_time ? 60s : 20s;
    sim.late_after = from_ms(robot_.sim.bounds.late_ms);
    sim.connect = [endpoint = plant_.endpoint()] { return hal::connect_stream(endpoint, 500ms); };
    // A plant of our own that is gone does not come back.
    if (robot_.sim.plant != "auto") sim.relink_for = from_ms(1e3 * robot_.sim.relink_s);
    sim.reader.fifo_priority = options_.virtual_time ? 0 : 95;  // it is this board's interrupt
    sim.reader.stack_bytes = std::size_t{64} * 1024;
    sim.on_report = [this](const std::string& json) { report_.put(json); };
    auto board = sim_hil::SimBoard::open(plant_.take_stream(), sim, why);
    if (!board) return fail(plant_.with_its_end(why));
    board_ = std::move(*board);
    if (uses_linux_board(graph_.spec())) {
      auto real = LinuxBoard::open(robot_, os_, why);
      if (!real) return fail(why);
      real_ = std::move(*real);
    }
    hal::MixedBoard devices(graph_.spec().board == "linux" ? real_->board() : *board_);
    if (!graph_.spec().device_boards.empty() && !mix(devices)) return false;
    rt::ConfigureOptions how;
    how.os = &os_;
    how.taps = MissionWatch::taps(graph_);
    how.recorded = Recording::wanted(prepared_, options_);
    if (!configure(prepared_, devices, how, options_, [this] { return real_ ? real_->problem() : std::string(); }))
      return board_->problem().empty() ? false : fail(board_->problem());
    if (real_)
      if (auto started = real_->start(); !started) return real_->print_problems(), false;
    if (real_ && !options_.quiet) real_->print_notes();
    // Before the first cycle: what --strict forbids to start shall not have moved anything.
    if (real_ && !accept_shortfalls(real_->shortfalls(), options_.strict)) return false;
    devices_ =
        DeviceWatch([this] { return complaints(); }, real_ ? real_->print_warnings() : std::vector<std::string>());
    for (const std::string& device : devices.unused())
      return fail("robot.device_boards." + device + ": no module and no actuator uses a device of this name");
    mission_.emplace(graph_);
    end_.emplace(*mission_);
    recording_ = Recording::open(prepared_, options_, graph_, os_);
    return true;
  }

  /// Devices with a board of their own.
  bool mix(hal::MixedBoard& devices) {
    for (const auto& [device, board] : graph_.spec().device_boards) {
      if (board.value == "sim" || board.value == "linux") {
        devices.assign(device, board.value == "sim" ? *board_ : real_->board());
        continue;
      }
      std::string why;
      if (!recorded_) recorded_ = open_dataset(options_, options_.virtual_time ? &clock_ : nullptr, os_, why);
      if (!recorded_) return fail(fmt::format("robot.device_boards.{}: {}", device, why));
      devices.assign(device, *recorded_);
    }
    return true;
  }

  /// Of real devices, and of the line to the plant, behind which all the others are. Thread: any.
  std::vector<std::string> complaints() const {
    std::vector<std::string> all = real_ ? real_->complaints() : std::vector<std::string>();
    if (const std::string trouble = board_->link_trouble(); !trouble.empty()) all.push_back("plant: " + trouble);
    return all;
  }

  // ---- virtual time

  // Looks at the mission between two grants, where the graph stands still.
  class Watched final : public hal::GrantSource {
   public:
    Watched(SimRun& run) : run_(run) {}
    hal::Result<hal::Time> next_grant(hal::Time done) override {
      if (++grants_ % 64 == 0 && (run_.over(done) || hal::stop_requested())) executor->request_stop();
      return run_.board_->next_grant(done);
    }
    rt::DiscreteExecutor* executor = nullptr;

   private:
    SimRun& run_;
    std::uint64_t grants_ = 0;
  };

  int run_virtual() {
    Watched grants(*this);
    rt::DiscreteOptions discrete;
    if (options_.duration_s > 0) discrete.duration = run_duration(options_);
    discrete.os = &os_;
    discrete.hash_topics = true;
    discrete.observer = observer_of(recording_);
    rt::DiscreteExecutor executor(graph_, clock_, grants, discrete);
    grants.executor = &executor;
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket =
        open_socket(prepared_, options_, executor.runner(), recording_.get(), clock_, &hal::request_stop);
    const hal::Time wall = real_os_.now();
    const auto report = executor.run();
    if (!report) {
      fail(report.error().where);
      return 2;
    }
    const double wall_s = msg::seconds(real_os_.now() - wall), plant_s = msg::seconds(report->reached);
    end_plant();
    if (report->end == rt::DiscreteReport::End::source_failed) {
      fail("the plant failed: " + board_->problem());
      return 1;
    }
    summary_.statistics(executor.runner());
    summary_.virtual_time(plant_s, wall_s);
    summary_.grants(board_->stats().grants, plant_s, wall_s);
    report_start_up(wall);
    summary_.hashes(executor.runner());
    if (recording_) recording_->finish(summary_);
    return verdict(false);
  }

  // ---- real time

  int run_real() {
    rt::RealTimeOptions how = real_time_options(options_);
    how.runner.observer = observer_of(recording_);
    rt::RealTimeExecutor executor(graph_, os_, how);
    const hal::ProcessUse before = hal::process_use();
    const hal::Time wall = real_os_.now();
    if (auto started = board_->start(); !started) return fail("the plant does not start: " + board_->problem()), 2;
    if (auto started = recorded_ ? recorded_->start() : hal::Status{}; !started) return fail(started.error().where), 2;
    if (parent_ && recording_ && recording_->ring_memory())
      if (auto kept = parent_->keep_ring(*recording_->ring_memory()); !kept)
        return fail(std::string("the parent does not take the flight ring: ") + kept.error().where), 2;
    if (parent_)
      if (auto watched = parent_->supervise(*graph_.memory()); !watched)
        return fail(std::string("the parent does not watch: ") + watched.error().where), 2;
    const auto refuse = [this] {
      if (parent_) parent_->ending();
      return 2;
    };
    const auto started = executor.start();
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return refuse();
    if (!started) return fail(started.error().where), refuse();
    const hal::Time first_cycle = real_os_.now();
    begin_ = executor.started_at();
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket = open_socket(prepared_, options_, executor.runner(), recording_.get(), os_, &hal::request_stop,
                                    [this] { return complaints(); });
    follow(executor);
    const hal::MemoryUse memory = hal::memory_use();  // with the threads' stacks
    if (parent_) parent_->ending();
    executor.stop();
    const hal::ProcessUse after = hal::process_use();
    const double wall_s = msg::seconds(real_os_.now() - wall);
    end_plant();
    summary_.statistics(executor.runner());
    if (recording_) recording_->finish(summary_);
    summary_.add_reasons("device", "devices", devices_.all());
    const double processor = 100 * msg::seconds(after.cpu - before.cpu) / wall_s;
    summary_.add("processor", fmt::format("{:.1f} % of a core", processor),
                 {{"wall_s", wall_s}, {"processor_percent", processor}});
    summary_.memory(memory);
    report_start_up(first_cycle);
    for (std::uint32_t t = 0; t < graph_.threads().size(); ++t) {
      evidence_.releases += executor.runner().thread_stats(t).releases.value();
      evidence_.missed += executor.runner().thread_stats(t).overruns.value();
    }
    summary_.add("missed deadlines", std::to_string(evidence_.missed), {{"missed_deadlines", evidence_.missed}});
    return verdict(true);
  }

  void follow(rt::RealTimeExecutor& executor) {
    LiveView view(graph_, executor.runner(), options_, devices_);
    const hal::Time begin = os_.now();
    for (hal::Time next = begin;; next = next + LiveView::kPeriod) {
      os_.sleep_until(next);
      const hal::Time now = os_.now();
      const bool ends = over(now) || board_->ended() || hal::stop_requested() ||
                        (options_.duration_s > 0 && now - begin > run_duration(options_));
      const auto* state = mission_->look();
      const std::string trouble = board_->link_trouble();
      view.show(now, !trouble.empty() ? trouble.c_str() : state ? phase_text(*state) : "running", ends);
      if (ends) return;
    }
  }

  const char* phase_text(const msg::MissionState& state) const {
    const msg::SafetyState& safety = mission_->safety();
    const bool by_hand = graph_.spec().guardian.arming == rt::GuardianSpec::Arming::manual;
    if (by_hand && !safety.permitted && safety.ready) return "ready: `sinew arm` lets it go";
    return to_string(state.phase);
  }

  // ---- both

  bool over(hal::Time now) { return end_->reached(now, report_.get()); }

  void end_plant() {
    board_->bye("the runtime ended the run");
    plant_.wait_for_end();
  }

  int verdict(bool real_time) {
    const auto report = parse_report(report_.get());
    if (!report) return summary_.finish("the plant sent no report", mission_->exists() ? 1 : 0);
    std::vector<std::string> faults;
    for (const auto& f : report->faults) faults.push_back(fmt::format("{}: struck {} times", f.text, f.affected));
    summary_.add_reasons("fault", "faults", faults);
    std::vector<std::string> failsafes;
    for (std::size_t i = 0; i < graph_.spec().failsafes.size(); ++i)
      if (mission_->safety().acted >> i & 1) failsafes.push_back(graph_.spec().failsafes[i].name + " acted");
    summary_.add_reasons("failsafe", "failsafes", failsafes);
    if (const hal::Time disarmed = mission_->safety().disarmed; disarmed.ns != 0) {
      const double at_s = msg::seconds(disarmed - begin_);
      summary_.add("disarmed", fmt::format("after {:.2f} s, while the actuators were live", at_s),
                   {{"disarmed_s", at_s}});
    }
    summary_.chains_decide(report->faults.empty());  // with a broken device a chain may well be late
    const auto invalid = judge(*report, real_time);
    const char* const validity = invalid.empty() ? "valid" : "invalid";
    if (!mission_->exists() && report->follow) return verdict_of_following(*report->follow, validity, invalid.empty());
    if (!mission_->exists()) return summary_.finish(fmt::format("{} run", validity), invalid.empty() ? 0 : 1);
    if (report->touched_down) report_landing(*report);
    const auto* state = mission_->look();
    const bool done = state && state->phase == msg::MissionPhase::done;
    const char* what = report->crashed          ? "crashed"
                       : !report->touched_down  ? "did not land"
                       : !soft_landing(*report) ? "landed hard"
                       : !good_landing(*report) ? "landed off the pad"
                       : !done                  ? "landed, but the mission does not know"
                                                : "landed on the pad";
    return summary_.finish(fmt::format("{}, {} run", what, validity),
                           good_landing(*report) && done && invalid.empty() ? 0 : 1);
  }

  int verdict_of_following(const FollowReport& f, const char* validity, bool valid) {
    summary_.add("ball in view",
                 fmt::format("{:.1f} % of the time it could be   (limit {:.0f} %)", 100 * f.in_view_share,
                             100 * kGoodInViewShare),
                 {{"in_view_share", f.in_view_share}, {"longest_loss_s", f.longest_loss_s}});
    summary_.add("ball off the axis",
                 fmt::format("{:.2f} deg RMS   (limit {:.0f} deg)", f.angle_rms_deg, kGoodAngle_deg),
                 {{"angle_rms_deg", f.angle_rms_deg}});
    summary_.add("level",
                 fmt::format("elevation {:.2f} deg RMS, horizon {:.2f} deg, on a base tilted by {:.2f} deg",
                             f.level_rms_deg, f.roll_rms_deg, f.base_tilt_rms_deg),
                 {{"level_rms_deg", f.level_rms_deg},
                  {"roll_rms_deg", f.roll_rms_deg},
                  {"base_tilt_rms_deg", f.base_tilt_rms_deg}});
    const msg::SafetyState& safety = mission_->safety();
    const bool faulted = safety.acted != 0 || safety.mode == msg::GuardianMode::safe;
    const char* what = !f.acquired          ? "never found the ball"
                       : !good_following(f) ? "did not keep the ball in view"
                       : faulted            ? "followed the ball, but a fault stopped it"
                                            : "followed the ball";
    return summary_.finish(fmt::format("{}, {} run", what, validity), good_following(f) && !faulted && valid ? 0 : 1);
  }

  /// Says what was measured against which bound, and why the run does not count.
  std::vector<std::string> judge(const FlightReport& report, bool real_time) {
    evidence_.real_time = real_time;
    evidence_.rate = options_.rate;
    evidence_.plant = report;
    evidence_.board = board_->stats();
    const auto findings = examine(evidence_, robot_.sim.bounds);
    Json validity = Json::array();
    for (const Finding& f : findings)
      validity.push_back(
          {{"bound", f.key}, {"what", f.what}, {"value", f.value}, {"most", f.bound}, {"holds", f.holds}});
    if (real_time)
      summary_.add("longest IMU gap", fmt::format("{:.3f} ms", imu_gap_max_s(evidence_) * 1e3),
                   {{"imu_gap_max_s", imu_gap_max_s(evidence_)}});
    if (evidence_.board.remote) {
      const sim_hil::ClockStats& c = evidence_.board.clock;
      summary_.add("clock of the plant",
                   fmt::format("known to {:.3f} ms, drift {:+.1f} ppm, {} exchanges", 1e3 * msg::seconds(c.worst_bound),
                               1e6 * c.drift, c.exchanges),
                   {{"clock_offset_s", msg::seconds(c.offset)},
                    {"clock_bound_s", msg::seconds(c.worst_bound)},
                    {"clock_drift_ppm", 1e6 * c.drift},
                    {"clock_exchanges", c.exchanges}});
    }
    auto reasons = invalid_because(findings);
    if (real_time && report.faults.empty())
      reasons.insert(reasons.end(), summary_.failed_chains().begin(), summary_.failed_chains().end());
    summary_.add_reasons("invalid", "invalid_because", reasons);
    summary_.keep({{"validity", validity}});
    return reasons;
  }

  void report_landing(const FlightReport& report) {
    summary_.add("landing error",
                 fmt::format("{:.3f} m        (limit {:.2f} m)", report.landing_error_m, kGoodLandingError_m),
                 {{"landing_error_m", report.landing_error_m}});
    summary_.add("touchdown speed",
                 fmt::format("{:.3f} m/s      (limit {:.2f} m/s)", report.touchdown_speed_mps, kGoodTouchdownSpeed_mps),
                 {{"touchdown_speed_mps", report.touchdown_speed_mps}});
    summary_.add("flight time", fmt::format("{:.1f} s", report.touchdown_s), {{"flight_s", report.touchdown_s}});
  }

  void report_start_up(hal::Time first_cycle) {
    if (program_) summary_.start_up(msg::seconds(first_cycle - *program_));
  }

  const std::optional<hal::Time> program_;
  const RunOptions& options_;
  const Prepared& prepared_;
  const RobotFile& robot_;
  rt::Graph& graph_;
  hal::Os& real_os_ = hal::system_os();
  std::optional<hal::ScaledOs> scaled_os_;
  hal::Os& os_;  // the robot's pace
  hal::ManualClock clock_;
  ReportBox report_;
  PlantProcess& plant_;
  ParentLine* const parent_;
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::unique_ptr<dataset::DatasetBoard> recorded_;  // of devices that are named so
  std::unique_ptr<LinuxBoard> real_;                 // likewise
  DeviceWatch devices_{[] { return std::vector<std::string>(); }};
  std::optional<MissionWatch> mission_;
  std::optional<FlightEnd> end_;
  std::unique_ptr<Recording> recording_;
  hal::Time begin_{};  // of the cycles
  RunEvidence evidence_;
  RunSummary summary_;
};

std::unique_ptr<PlantProcess> open_plant(const Prepared& prepared, const RunOptions& options, std::string& why) {
  const SimOptions& sim = prepared.robot.sim;
  PlantRequest request;
  request.endpoint = sim.plant;
  request.world = sim.world;
  request.seed = prepared.graph->spec().seed;
  request.camera_width = sim.camera_width;
  request.camera_height = sim.camera_height;
  request.lockstep = options.virtual_time;
  request.extra = options.plant_args;
  if (!options.faults.empty() && request.endpoint != "auto") {
    why = "--fault: only a plant that this run starts itself (plant \"auto\") plays faults";
    return nullptr;
  }
  // Drives that the plant has on a bus are its own, whatever board the robot reaches them by.
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
  const std::optional<hal::Time> program = hal::process_start();  // the runtime may be a copy of it, started later
  const auto plant = open_plant(prepared, options, why);
  if (!plant) {
    std::fprintf(stderr, "sinew: %s\n", why.c_str());
    return 2;
  }
  if (options.virtual_time || options.unsupervised || prepared.graph->spec().actuators.empty())
    return SimRun(prepared, options, *plant, nullptr, program).run();

  Supervised supervised;
  supervised.robot = prepared.graph->spec().robot;
  supervised.runs = Recording::folder_of(prepared, options);
  StopWay to_plant{.name = "plant", .line = open_stop_line(plant->endpoint(), 2s, why)};
  if (!to_plant.line) std::fprintf(stderr, "warning: no stop line to the plant: %s\n", why.c_str());
  // The plant may have been away and come back, which the runtime outlives and a line of old does not.
  to_plant.open = [&] { return open_stop_line(plant->endpoint(), 200ms, why); };
  supervised.stops.push_back(std::move(to_plant));
  add_stops_of_linux_devices(prepared, supervised.stops);
  supervised.body = [&](ParentLine& line) {
    plant->leave_to_parent();
    return SimRun(prepared, options, *plant, &line, program).run();
  };
  supervised.in_parent = [&] { plant->leave_to_runtime(); };
  ParentOptions parent = prepared.robot.parent;
  parent.hang = hang_of(parent, prepared.graph->spec(), options.rate);
  const int code = run_with_parent(parent, std::move(supervised));
  plant->wait_for_end();  // after a fault it goes on alone for a while, and what it then says belongs to the run
  return code;
}

}  // namespace sinew::app
