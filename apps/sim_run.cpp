#include "apps/sim_run.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <mutex>
#include <optional>

#include "apps/flight_report.hpp"
#include "apps/live_view.hpp"
#include "apps/plant_process.hpp"
#include "apps/run_summary.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"
#include "hal/scaled_os.hpp"
#include "rt/discrete_executor.hpp"
#include "rt/real_time_executor.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr rt::Duration kAfterMission = 300ms;  // so that what happens at rest is in the report

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

class SimRun {
 public:
  SimRun(Prepared& prepared, const RunOptions& options)
      : options_(options),
        robot_(prepared.robot),
        graph_(*prepared.graph),
        os_(options.rate == 1 ? real_os_ : scaled_os_.emplace(real_os_, options.rate)),
        summary_(graph_, options.virtual_time, {.json = options.json, .quiet = options.quiet}) {}

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
    PlantRequest request;
    request.endpoint = robot_.sim.plant;
    request.seed = graph_.spec().seed;
    request.camera_width = robot_.sim.camera_width;
    request.camera_height = robot_.sim.camera_height;
    request.lockstep = options_.virtual_time;
    request.extra = options_.plant_args;
    if (!options_.faults.empty() && request.endpoint != "auto")
      return fail("--fault: only a plant that this run starts itself (plant \"auto\") plays faults");
    for (const std::string& fault : options_.faults) request.extra.insert(request.extra.end(), {"--fault", fault});
    std::string why;
    plant_ = PlantProcess::open(request, why);
    if (!plant_) return fail(why);
    sim_hil::SimOptions sim;
    sim.mode = options_.virtual_time ? sim_hil::Mode::lockstep : sim_hil::Mode::free_running;
    sim.robot = graph_.spec().robot;
    sim.seed = graph_.spec().seed;
    sim.clock = options_.virtual_time ? static_cast<const hal::Clock*>(&clock_) : &os_;
    sim.os = &real_os_;
    sim.rate = options_.rate;
    sim.reader.fifo_priority = options_.virtual_time ? 0 : 95;  // it is this board's interrupt
    sim.reader.stack_bytes = std::size_t{64} * 1024;
    sim.on_report = [this](const std::string& json) { report_.put(json); };
    auto board = sim_hil::SimBoard::open(plant_->take_stream(), sim, why);
    if (!board) return fail(why);
    board_ = std::move(*board);
    rt::ConfigureOptions configure;
    configure.os = options_.virtual_time ? nullptr : &os_;
    configure.taps = MissionWatch::taps(graph_);
    if (auto ready = graph_.configure(*board_, configure); !ready) {
      for (const auto& p : graph_.configure_problems())
        std::fprintf(stderr, "%s\n", rt::to_string(p, options_.robot).c_str());
      return fail(board_->problem().empty() ? std::string(ready.error().where) : board_->problem());
    }
    mission_.emplace(graph_);
    return true;
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
    rt::DiscreteExecutor executor(graph_, clock_, grants, discrete);
    grants.executor = &executor;
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
    summary_.hashes(executor.runner());
    return verdict(false);
  }

  // ---- real time

  int run_real() {
    rt::RealTimeExecutor executor(graph_, os_, real_time_options(options_.rate));
    const hal::ProcessUse before = hal::process_use();
    const hal::Time wall = real_os_.now();
    if (auto started = board_->start(); !started) return fail("the plant does not start: " + board_->problem()), 2;
    if (auto started = executor.start(); !started) return fail(started.error().where), 2;
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return 2;
    follow(executor);
    const hal::MemoryUse memory = hal::memory_use();  // with the threads' stacks
    executor.stop();
    const hal::ProcessUse after = hal::process_use();
    const double wall_s = msg::seconds(real_os_.now() - wall);
    end_plant();
    summary_.statistics(executor.runner());
    const double processor = 100 * msg::seconds(after.cpu - before.cpu) / wall_s;
    summary_.add("processor", fmt::format("{:.1f} % of a core", processor),
                 {{"wall_s", wall_s}, {"processor_percent", processor}});
    summary_.memory(memory);
    const std::uint64_t n = missed(executor.runner());
    summary_.add("missed deadlines", std::to_string(n), {{"missed_deadlines", n}});
    return verdict(true);
  }

  void follow(rt::RealTimeExecutor& executor) {
    LiveView view(graph_, executor.runner(), options_);
    const hal::Time begin = os_.now();
    for (hal::Time next = begin;; next = next + LiveView::kPeriod) {
      os_.sleep_until(next);
      const hal::Time now = os_.now();
      const bool ends = over(now) || board_->ended() || hal::stop_requested() ||
                        (options_.duration_s > 0 && now - begin > run_duration(options_));
      const auto* state = mission_->look();
      view.show(now, state ? to_string(state->phase) : "running", ends);
      if (ends) return;
    }
  }

  static std::uint64_t missed(rt::Runner& runner) {
    std::uint64_t n = 0;
    for (std::uint32_t t = 0; t < runner.graph().threads().size(); ++t) n += runner.thread_stats(t).overruns.value();
    return n;
  }

  // ---- both

  bool over(hal::Time now) {
    mission_->look();
    if (!mission_->ended()) return false;
    if (mission_end_ == hal::kNever) mission_end_ = now;
    return now - mission_end_ >= kAfterMission;
  }

  void end_plant() {
    board_->bye("the runtime ended the run");
    plant_->wait_for_end();
  }

  int verdict(bool real_time) {
    const auto report = parse_report(report_.get());
    if (!report) return summary_.finish("the plant sent no report", mission_->exists() ? 1 : 0);
    std::vector<std::string> faults;
    for (const auto& f : report->faults) faults.push_back(fmt::format("{}: struck {} times", f.text, f.affected));
    summary_.add_reasons("fault", "faults", faults);
    const auto invalid = invalid_because(*report, board_->stats(), real_time);
    summary_.add_reasons("invalid", "invalid_because", invalid);
    if (real_time)
      summary_.add("longest IMU gap", fmt::format("{:.3f} ms", report->imu_gap_max_s * 1e3),
                   {{"imu_gap_max_s", report->imu_gap_max_s}});
    const char* const validity = invalid.empty() ? "valid" : "invalid";
    if (!mission_->exists()) return summary_.finish(fmt::format("{} run", validity), invalid.empty() ? 0 : 1);
    if (report->touched_down) report_landing(*report);
    const auto* state = mission_->look();
    const bool done = state && state->phase == msg::MissionPhase::done;
    const char* what = report->crashed          ? "crashed"
                       : !report->touched_down  ? "did not land"
                       : !good_landing(*report) ? "landed badly"
                       : !done                  ? "landed, but the mission does not know"
                                                : "landed on the pad";
    return summary_.finish(fmt::format("{}, {} run", what, validity),
                           good_landing(*report) && done && invalid.empty() ? 0 : 1);
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

  const RunOptions& options_;
  const RobotFile& robot_;
  rt::Graph& graph_;
  hal::Os& real_os_ = hal::linux_os();
  std::optional<hal::ScaledOs> scaled_os_;
  hal::Os& os_;  // the robot's pace
  hal::ManualClock clock_;
  ReportBox report_;
  std::unique_ptr<PlantProcess> plant_;
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::optional<MissionWatch> mission_;
  hal::Time mission_end_ = hal::kNever;
  RunSummary summary_;
};

}  // namespace

int run_on_sim(Prepared& prepared, const RunOptions& options) { return SimRun(prepared, options).run(); }

}  // namespace sinew::app
