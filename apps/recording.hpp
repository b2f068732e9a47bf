#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/record_options.hpp"
#include "apps/run_summary.hpp"
#include "record/run/run_recorder.hpp"

namespace sinew::app {

struct Prepared;
struct RunOptions;

/// Topics that the robot does not have.
std::vector<rt::Problem> check_recording(const RecordOptions& record, const rt::Graph& graph);

/// The recording of one run: FOLDER/ROBOT-TIME/run.mcap.
/// Thread:  owner.
class Recording {
 public:
  /// Null when the run is not to be recorded, or after a warning when it cannot be: a robot flies without, too. The
  /// graph is configured with ConfigureOptions::recorded, which wanted() tells. In real time it reads along from now
  /// on.
  static std::unique_ptr<Recording> open(const Prepared& prepared, const RunOptions& options, rt::Graph& graph,
                                         const hal::Clock& clock);
  static bool wanted(const Prepared& prepared, const RunOptions& options);

  rt::RunObserver& observer() { return recorder_->observer(); }
  /// After the executor has ended: completes the file and tells the summary.
  void finish(RunSummary& summary);

 private:
  Recording(std::string folder, std::unique_ptr<record::RunRecorder> recorder)
      : folder_(std::move(folder)), recorder_(std::move(recorder)) {}
  std::string folder_;
  std::unique_ptr<record::RunRecorder> recorder_;
};

/// For RunnerOptions and DiscreteOptions: null without a recording.
inline rt::RunObserver* observer_of(const std::unique_ptr<Recording>& recording) {
  return recording ? &recording->observer() : nullptr;
}

}  // namespace sinew::app
