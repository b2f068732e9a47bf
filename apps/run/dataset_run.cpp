#include "apps/run/dataset_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/command/command.hpp"
#include "apps/robot/without_camera.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/run_log.hpp"
#include "apps/run/session.hpp"
#include "apps/run/tilt_error.hpp"
#include "apps/view/plot.hpp"
#include "dataset/dataset_board.hpp"
#include "dataset/ground_truth.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr double kSettle_s = 5;  // the attitude may take this long with unknown bias
constexpr double kGoodTilt_deg = 2.0;
constexpr hal::Duration kLastSamples = 100ms;  // on their way through the robot

/// The first of this type; null: the robot has none.
template <class M>
M* find_module(rt::Graph& graph) {
  for (const auto& m : graph.modules())
    if (auto* module = dynamic_cast<M*>(m.module.get())) return module;
  return nullptr;
}

class RecordedBoard final : public RunBoard {
 public:
  std::string name() const override { return "dataset"; }

  bool open(RunContext& run, std::string& why) override {
    board_ = open_dataset(run.options, run.options.virtual_time ? &run.clock : nullptr, run.os, why);
    if (!board_) return false;
    if (board_->images() == 0) {
      rt::GraphSpec spec = run.prepared.robot.graph;
      left_out_ = leave_out_camera(spec);
      run.prepared.graph = std::make_unique<rt::Graph>(std::move(spec), run.prepared.types);
    }
    return true;
  }

  hal::Board& devices() override { return *board_; }
  hal::GrantSource& grants() override { return *board_; }

  bool start(RunContext& run, std::string& why) override {
    if (!run.options.virtual_time) {
      if (auto begun = board_->start(); !begun) {
        why = begun.error().where;
        return false;
      }
      end_ = board_->end() + kLastSamples;
    }
    play_truth(run);
    return true;
  }

  bool over(RunContext& run, hal::Time now) override {
    run.mission->look();
    return run.mission->ended() || (!run.options.virtual_time && now >= end_);
  }

  int report(RunContext& run, RunSummary& summary) override {
    if (board_->images() == 0)
      summary.add("no images", fmt::format("left out: {}", fmt::join(left_out_, " ")), {{"left_out", left_out_}});
    std::string samples = fmt::format("{} of the IMU, {} images", board_->imu_samples(), board_->images());
    if (board_->images_lost() > 0)
      samples += fmt::format(", {} lost: {}", board_->images_lost(), board_->image_problem());
    summary.add(
        "samples", samples,
        {{"imu_samples", board_->imu_samples()}, {"images", board_->images()}, {"images_lost", board_->images_lost()}});
    if (const auto* motion = find_module<RunLog<msg::MotionField>>(run.graph())) {
      const auto& all = motion->messages();
      const auto moving = std::count_if(all.begin(), all.end(), [](const auto& m) { return m.moving != 0; });
      summary.add("motion field", fmt::format("{} fields, {} report motion", all.size(), moving),
                  {{"motion_fields", all.size()}, {"motion_fields_moving", moving}});
    }
    const auto* nav = find_module<RunLog<msg::NavState>>(run.graph());
    return nav ? report_tilt(*nav, run.options, summary)
               : summary.finish(hal::stop_requested() ? "" : "ran to its end", 0);
  }

 private:
  int report_tilt(const RunLog<msg::NavState>& log, const RunOptions& options, RunSummary& summary) const {
    if (log.lost() > 0)
      summary.add("warning", fmt::format("{} states not kept", log.lost()), {{"states_not_kept", log.lost()}});
    std::string why;
    const auto truth = dataset::GroundTruth::open(options.data, why);
    if (!truth)
      return summary.finish("no ground truth in " + options.data, truth.error().code == hal::Errc::not_found ? 0 : 1);
    const TiltErrors errors = tilt_errors(log.messages(), kSettle_s, [&](const msg::NavState& e, msg::Quat& q) {
      dataset::GroundTruthSample s;
      if (!truth->at(board_->dataset_stamp(e.stamp), s)) return false;
      q = s.q_world_base;
      return true;
    });
    if (errors.compared == 0)
      return summary.finish(fmt::format("nothing to compare with the ground truth after {:.0f} s", kSettle_s), 1);
    summary.add("tilt error",
                fmt::format("{:.3f} deg RMS, {:.3f} deg max from {:.0f} s on, {} states (limit {:.1f} deg RMS)",
                            errors.rms_deg, errors.max_deg, kSettle_s, errors.compared, kGoodTilt_deg),
                {{"tilt_rms_deg", errors.rms_deg}, {"tilt_max_deg", errors.max_deg}, {"states", errors.compared}});
    summary.measure({"tilt_rms_deg", "tilt error", "deg RMS", errors.rms_deg, kGoodTilt_deg, {}});
    if (!options.plot.empty() && !write_plot(errors, options.plot, summary)) return 1;
    const bool good = errors.rms_deg < kGoodTilt_deg;
    return summary.finish(good ? "attitude within its limit" : "attitude beyond its limit", good ? 0 : 1);
  }

  static bool write_plot(const TiltErrors& errors, const std::string& file, RunSummary& summary) {
    Plot plot;
    plot.title = fmt::format("Tilt error: {:.3f} deg RMS from {} s on", errors.rms_deg, kSettle_s);
    plot.x_label = "time since the first estimate (s)";
    plot.y_label = "angle between true and estimated up (deg)";
    plot.series.push_back({"error", errors.over_time});
    if (const std::string why = write_plots(file, std::span(&plot, 1)); !why.empty()) {
      fail("--plot " + why);
      return false;
    }
    summary.add("plot", file, {{"plot", file}});
    return true;
  }

  /// Hands the truth to the module that publishes it. Errors in the truth are left to the report.
  void play_truth(RunContext& run) {
    GroundTruthSource* const module = find_ground_truth(run.graph());
    std::string why;
    const auto truth =
        module ? dataset::GroundTruth::open(run.options.data, why) : hal::Error{hal::Errc::not_found, ""};
    if (!truth) return;
    const std::int64_t begin_ns = board_->dataset_stamp({});
    std::vector<msg::NavState> states;
    for (const dataset::GroundTruthSample& s : truth->samples())
      if (s.stamp_ns >= begin_ns) states.push_back(true_state(s, rt::Time{s.stamp_ns - begin_ns}));
    module->play(std::move(states));
  }

  std::unique_ptr<dataset::DatasetBoard> board_;
  std::vector<std::string> left_out_;
  hal::Time end_ = hal::kNever;  // real time
};

}  // namespace

int run_on_dataset(Prepared& prepared, const RunOptions& options) {
  RecordedBoard board;
  return run_session(prepared, options, board, nullptr, hal::program_start());
}

}  // namespace sinew::app
