#include "apps/run/dataset_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "apps/robot/without_camera.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/recording.hpp"
#include "apps/run/run_log.hpp"
#include "apps/run/run_summary.hpp"
#include "apps/run/tilt_error.hpp"
#include "apps/view/plot.hpp"
#include "dataset/dataset_board.hpp"
#include "dataset/ground_truth.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/real_time_executor.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr double kSettle_s = 5;  // the attitude may take this long with unknown bias
constexpr double kGoodTilt_deg = 2.0;

/// The first of this type; null: the robot has none.
template <class M>
M* find_module(rt::Graph& graph) {
  for (const auto& m : graph.modules())
    if (auto* module = dynamic_cast<M*>(m.module.get())) return module;
  return nullptr;
}

class DatasetRun {
 public:
  DatasetRun(Prepared& prepared, const RunOptions& options) : prepared_(prepared), options_(options) {}

  int run() {
    if (!open()) return 2;
    summary_.emplace(*graph_, options_.virtual_time,
                     RunSummary::Form{.json = options_.json, .quiet = options_.quiet, .trace = options_.trace});
    if (board_->images() == 0)
      summary_->add("no images", fmt::format("left out: {}", fmt::join(left_out_, " ")), {{"left_out", left_out_}});
    const bool ran = options_.virtual_time ? run_virtual() : run_real();
    return ran ? report() : failed_with_;
  }

 private:
  bool fail(const std::string& what) {
    std::fprintf(stderr, "sinew: %s\n", what.c_str());
    return false;
  }

  bool open() {
    std::string why;
    board_ = open_dataset(options_, options_.virtual_time ? &clock_ : nullptr, os_, why);
    if (!board_) return fail(why);
    if (board_->images() == 0) {
      rt::GraphSpec spec = prepared_.robot.graph;
      left_out_ = leave_out_camera(spec);
      prepared_.graph = std::make_unique<rt::Graph>(std::move(spec), prepared_.types);
    }
    graph_ = prepared_.graph.get();
    rt::ConfigureOptions how;
    how.os = &os_;
    how.recorded = Recording::wanted(prepared_, options_);
    if (!configure(prepared_, *board_, how, options_)) return false;
    recording_ = Recording::open(prepared_, options_, *graph_, os_);
    return true;
  }

  /// Hands the truth to the module that publishes it. The report says what is wrong with it.
  void play_truth() {
    auto* const module = find_module<GroundTruthSource>(*graph_);
    std::string why;
    const auto truth = module ? dataset::GroundTruth::open(options_.data, why) : hal::Error{hal::Errc::not_found, ""};
    if (!truth) return;
    const std::int64_t begin_ns = board_->dataset_stamp({});
    std::vector<msg::NavState> states;
    for (const dataset::GroundTruthSample& s : truth->samples())
      if (s.stamp_ns >= begin_ns) states.push_back(true_state(s, rt::Time{s.stamp_ns - begin_ns}));
    module->play(std::move(states));
  }

  bool run_virtual() {
    play_truth();
    rt::DiscreteOptions discrete;
    if (options_.duration_s > 0) discrete.duration = run_duration(options_);
    discrete.os = &os_;
    discrete.hash_topics = true;
    discrete.observer = observer_of(recording_);
    rt::DiscreteExecutor executor(*graph_, clock_, *board_, discrete);
    executor.runner().ask_for_zones(!options_.trace.empty());
    const auto socket = open_socket(prepared_, options_, executor.runner(), recording_.get(), clock_,
                                    [&executor] { executor.request_stop(); });
    const hal::Time wall = os_.now();
    const auto done = executor.run();
    if (!done) return fail(done.error().where);
    if (done->end == rt::DiscreteReport::End::source_failed) return fail(done->error.where);
    const double wall_s = msg::seconds(os_.now() - wall), run_s = msg::seconds(done->reached);
    summary_->statistics(executor.runner());
    summary_->virtual_time(run_s, wall_s);
    summary_->hashes(executor.runner());
    if (recording_) recording_->finish(*summary_);
    return true;
  }

  bool run_real() {
    rt::RealTimeOptions how = real_time_options(options_);
    how.runner.observer = observer_of(recording_);
    rt::RealTimeExecutor executor(*graph_, os_, how);
    const auto started = executor.start();
    if (!accept_shortfalls(executor.shortfalls(), options_.strict)) return failed_with_ = 2, false;
    if (!started) return fail(started.error().where);
    executor.runner().ask_for_zones(!options_.trace.empty());
    if (auto begun = board_->start(); !begun) return fail(begun.error().where);
    play_truth();
    const auto socket = open_socket(prepared_, options_, executor.runner(), recording_.get(), os_, &hal::request_stop);
    const hal::Time begin = os_.now();
    const hal::Time end =
        options_.duration_s > 0 ? std::min(board_->end(), begin + run_duration(options_)) : board_->end();
    while (os_.now() < end + 100ms && !hal::stop_requested()) os_.sleep_until(std::min(os_.now() + 200ms, end + 100ms));
    executor.stop();
    summary_->statistics(executor.runner());
    if (recording_) recording_->finish(*summary_);
    return true;
  }

  int report() {
    std::string samples = fmt::format("{} of the IMU, {} images", board_->imu_samples(), board_->images());
    if (board_->images_lost() > 0)
      samples += fmt::format(", {} lost: {}", board_->images_lost(), board_->image_problem());
    summary_->add(
        "samples", samples,
        {{"imu_samples", board_->imu_samples()}, {"images", board_->images()}, {"images_lost", board_->images_lost()}});
    if (const auto* motion = find_module<RunLog<msg::MotionField>>(*graph_)) {
      const auto& all = motion->messages();
      const auto moving = std::count_if(all.begin(), all.end(), [](const auto& m) { return m.moving != 0; });
      summary_->add("motion field", fmt::format("{} fields, {} report motion", all.size(), moving),
                    {{"motion_fields", all.size()}, {"motion_fields_moving", moving}});
    }
    const auto* nav = find_module<RunLog<msg::NavState>>(*graph_);
    return nav ? report_tilt(*nav) : summary_->finish("ran to its end", 0);
  }

  int report_tilt(const RunLog<msg::NavState>& log) {
    if (log.lost() > 0)
      summary_->add("warning", fmt::format("{} states not kept", log.lost()), {{"states_not_kept", log.lost()}});
    std::string why;
    const auto truth = dataset::GroundTruth::open(options_.data, why);
    if (!truth)
      return summary_->finish("no ground truth in " + options_.data,
                              truth.error().code == hal::Errc::not_found ? 0 : 1);
    const TiltErrors errors = tilt_errors(log.messages(), kSettle_s, [&](const msg::NavState& e, msg::Quat& q) {
      dataset::GroundTruthSample s;
      if (!truth->at(board_->dataset_stamp(e.stamp), s)) return false;
      q = s.q_world_base;
      return true;
    });
    if (errors.compared == 0)
      return summary_->finish(fmt::format("nothing to compare with the ground truth after {:.0f} s", kSettle_s), 1);
    summary_->add("tilt error",
                  fmt::format("{:.3f} deg RMS, {:.3f} deg max from {:.0f} s on, {} states (limit {:.1f} deg RMS)",
                              errors.rms_deg, errors.max_deg, kSettle_s, errors.compared, kGoodTilt_deg),
                  {{"tilt_rms_deg", errors.rms_deg}, {"tilt_max_deg", errors.max_deg}, {"states", errors.compared}});
    if (!options_.plot.empty() && !write_plot(errors)) return 1;
    const bool good = errors.rms_deg < kGoodTilt_deg;
    return summary_->finish(good ? "attitude within its limit" : "attitude beyond its limit", good ? 0 : 1);
  }

  bool write_plot(const TiltErrors& errors) {
    Plot plot;
    plot.title = fmt::format("Tilt error: {:.3f} deg RMS from {} s on", errors.rms_deg, kSettle_s);
    plot.x_label = "time since the first estimate (s)";
    plot.y_label = "angle between true and estimated up (deg)";
    plot.series.push_back({"error", errors.over_time});
    std::ofstream out(options_.plot, std::ios::binary);
    out << to_svg(plot);
    out.close();
    if (!out) return fail("--plot " + options_.plot + ": cannot be written");
    summary_->add("plot", options_.plot, {{"plot", options_.plot}});
    return true;
  }

  Prepared& prepared_;
  const RunOptions& options_;
  rt::Graph* graph_ = nullptr;
  hal::Os& os_ = hal::system_os();
  hal::ManualClock clock_;
  std::unique_ptr<dataset::DatasetBoard> board_;
  std::vector<std::string> left_out_;
  int failed_with_ = 1;
  std::unique_ptr<Recording> recording_;
  std::optional<RunSummary> summary_;  // once the graph is what it stays
};

}  // namespace

int run_on_dataset(Prepared& prepared, const RunOptions& options) { return DatasetRun(prepared, options).run(); }

}  // namespace sinew::app
