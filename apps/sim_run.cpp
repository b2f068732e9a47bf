#include "apps/sim_run.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <mutex>

#include "apps/flight_report.hpp"
#include "apps/graph_text.hpp"
#include "apps/plant_process.hpp"
#include "apps/status_table.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"
#include "rt/discrete_executor.hpp"
#include "rt/real_time_executor.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr rt::Duration kAfterMission = 300ms;  // so that what happens at rest is in the report
constexpr rt::Duration kTablePeriod = 200ms, kLinePeriod = 2s;

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
      : options_(options), robot_(prepared.robot), graph_(*prepared.graph) {}

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
    std::string why;
    plant_ = PlantProcess::open(request, why);
    if (!plant_) return fail(why);
    sim_hil::SimOptions sim;
    sim.mode = options_.virtual_time ? sim_hil::Mode::lockstep : sim_hil::Mode::free_running;
    sim.robot = graph_.spec().robot;
    sim.seed = graph_.spec().seed;
    sim.clock = options_.virtual_time ? static_cast<const hal::Clock*>(&clock_) : &os_;
    sim.os = &os_;
    sim.reader.fifo_priority = options_.virtual_time ? 0 : 95;  // it is this board's interrupt
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
    if (options_.duration_s > 0) discrete.duration = duration();
    discrete.os = &os_;
    discrete.hash_topics = true;
    rt::DiscreteExecutor executor(graph_, clock_, grants, discrete);
    grants.executor = &executor;
    const hal::Time wall = os_.now();
    const auto report = executor.run();
    if (!report) {
      fail(report.error().where);
      return 2;
    }
    const double wall_s = msg::seconds(os_.now() - wall), plant_s = msg::seconds(report->reached);
    end_plant();
    if (report->end == rt::DiscreteReport::End::source_failed) {
      fail("the plant failed: " + board_->problem());
      return 1;
    }
    if (!options_.quiet) std::printf("%s", run_summary(graph_, executor.runner()).c_str());
    std::printf("virtual time        %.3f s in %.3f s: %.1f times real time\n", plant_s, wall_s, plant_s / wall_s);
    for (std::uint32_t t = 0; t < graph_.topics().size(); ++t)
      std::printf("hash %-24s %016llx\n", graph_.topics()[t].name.c_str(),
                  static_cast<unsigned long long>(executor.runner().topic_hash(t)));
    return verdict(false);
  }

  // ---- real time

  int run_real() {
    rt::RealTimeExecutor executor(graph_, os_, real_time_options());
    const hal::ProcessUse before = hal::process_use();
    const hal::Time wall = os_.now();
    if (auto started = board_->start(); !started) return fail("the plant does not start: " + board_->problem()), 2;
    if (auto started = executor.start(); !started) return fail(started.error().where), 2;
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return 2;
    follow(executor);
    executor.stop();
    const hal::ProcessUse after = hal::process_use();
    const double wall_s = msg::seconds(os_.now() - wall);
    end_plant();
    if (!options_.quiet) std::printf("%s", run_summary(graph_, executor.runner()).c_str());
    std::printf("processor           %.1f %% of a core; memory %.1f MB\n",
                100 * msg::seconds(after.cpu - before.cpu) / wall_s, static_cast<double>(after.rss_bytes) * 1e-6);
    std::printf("missed deadlines    %llu\n", static_cast<unsigned long long>(missed(executor.runner())));
    return verdict(true);
  }

  void follow(rt::RealTimeExecutor& executor) {
    StatusTable table(graph_, executor.runner());
    const bool live = !options_.plain && !options_.quiet && hal::output_is_terminal();
    const hal::Time begin = os_.now();
    int lines = 0;
    for (hal::Time next = begin;; next = next + kTablePeriod) {
      os_.sleep_until(next);
      const hal::Time now = os_.now();
      const bool ends = over(now) || board_->ended() || hal::stop_requested() ||
                        (options_.duration_s > 0 && now - begin > duration());
      if (live) {
        if (lines > 0) std::printf("\033[%dA", lines);  // back to the table's first line
        const std::string text = mission_line(now - begin) + table.render(now, hal::terminal_columns());
        lines = 0;
        for (const char c : text) {
          if (c == '\n') std::printf("\033[K"), ++lines;
          std::putchar(c);
        }
      } else if (!options_.quiet && (ends || (now - begin) % kLinePeriod < kTablePeriod)) {
        std::printf("%s", mission_line(now - begin).c_str());
      }
      std::fflush(stdout);
      if (ends) return;
    }
  }

  std::string mission_line(hal::Duration since) {
    const auto* state = mission_->look();
    return fmt::format("{:6.1f} s  {}\n", msg::seconds(since), state ? to_string(state->phase) : "running");
  }

  static std::uint64_t missed(rt::Runner& runner) {
    std::uint64_t n = 0;
    for (std::uint32_t t = 0; t < runner.graph().threads().size(); ++t) n += runner.thread_stats(t).overruns.value();
    return n;
  }

  // ---- both

  rt::Duration duration() const { return rt::Duration{static_cast<std::int64_t>(options_.duration_s * 1e9)}; }

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
    if (!report) {
      std::printf("result              the plant sent no report\n");
      return mission_->exists() ? 1 : 0;
    }
    const auto invalid = invalid_because(*report, board_->stats(), real_time);
    for (const auto& reason : invalid) std::printf("invalid             %s\n", reason.c_str());
    if (real_time) std::printf("longest IMU gap     %.3f ms\n", report->imu_gap_max_s * 1e3);
    if (!mission_->exists()) return invalid.empty() ? 0 : 1;
    if (report->touched_down) {
      std::printf("landing error       %.3f m        (limit %.2f m)\n", report->landing_error_m, kGoodLandingError_m);
      std::printf("touchdown speed     %.3f m/s      (limit %.2f m/s)\n", report->touchdown_speed_mps,
                  kGoodTouchdownSpeed_mps);
      std::printf("flight time         %.1f s\n", report->touchdown_s);
    }
    const auto* state = mission_->look();
    const bool done = state && state->phase == msg::MissionPhase::done;
    const char* what = report->crashed          ? "crashed"
                       : !report->touched_down  ? "did not land"
                       : !good_landing(*report) ? "landed badly"
                       : !done                  ? "landed, but the mission does not know"
                                                : "landed on the pad";
    std::printf("result              %s, %s run\n", what, invalid.empty() ? "valid" : "invalid");
    return good_landing(*report) && done && invalid.empty() ? 0 : 1;
  }

  const RunOptions& options_;
  const RobotFile& robot_;
  rt::Graph& graph_;
  hal::Os& os_ = hal::linux_os();
  hal::ManualClock clock_;
  ReportBox report_;
  std::unique_ptr<PlantProcess> plant_;
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::optional<MissionWatch> mission_;
  hal::Time mission_end_ = hal::kNever;
};

}  // namespace

int run_on_sim(Prepared& prepared, const RunOptions& options) { return SimRun(prepared, options).run(); }

}  // namespace sinew::app
