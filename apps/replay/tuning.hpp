#pragma once
// Recordings executed again with other parameters, many at a time, each scored by an error.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/replay/replay_score.hpp"
#include "apps/replay/swept_params.hpp"
#include "apps/sweep/process_pool.hpp"
#include "record/run/comparison.hpp"

namespace sinew::app {

struct TuningTask {
  std::vector<std::string> files;
  std::vector<std::string> params;            // parse_sweep()
  std::string error;                          // a quantity, as record::means() knows it
  bool against_truth = true;                  // else against the record
  std::string truth;                          // topic; empty: the one that the file has
  std::optional<double> from_s{}, until_s{};  // of each record: what counts
  unsigned jobs = 0;                          // at a time; 0: one for each processor
  double patience_s = 600;                    // of real time, for one replay
};

/// The result of one point, or of the recorded parameters.
struct Score {
  record::Deviation error;               // over all files
  std::vector<record::Deviation> files;  // each
  std::uint64_t missing = 0;             // messages that the recorded version published and this one did not
  std::vector<std::string> stopped{};    // modules, or whole replays, that were not executed to the end, in words
  /// Nearly all messages were published: a silent filter makes no errors.
  bool counts() const;
};

/// Thread:  owner.
class Tuning {
 public:
  /// Errors:  false, with `why`: files, parameters, the error, no truth to compare with.
  bool prepare(TuningTask task, const rt::ModuleTypes& types, std::string& why);

  const std::vector<SweptParam>& params() const { return params_; }
  const std::vector<SweepPoint>& points() const { return points_; }
  const std::string& error_name() const { return error_; }
  const std::string& unit() const { return unit_; }
  const std::vector<std::string>& modules() const { return modules_; }  // that are executed again

  /// Executes everything, each point on each file in a copy of this process: one that crashes or hangs is a score that
  /// does not count. Calls `progress` with the number of newly finished ones, of points() x files.
  /// Errors:  false, with `why`: also when this process has other threads.
  bool run(const std::function<void(std::size_t)>& progress, std::string& why);
  const std::vector<Score>& scores() const { return scores_; }  // of points()
  const Score& recorded() const { return recorded_; }
  /// The point with the smallest error of those that count; nothing: none does.
  std::optional<std::size_t> best() const;
  /// For each module the line of its parameters in the (first) robot file, with the values of this point.
  std::string robot_file_lines(std::size_t point) const;

 private:
  struct File;
  bool open(const std::string& path, std::string& why);
  bool choose_error(const rt::Graph& graph, std::string& why);
  void choose_modules(const rt::Graph& graph, std::uint32_t error_module);
  bool replay(std::size_t point, const File& file, ReplayScore& result, std::string& why) const;
  int replay_and_print(std::size_t replay) const;
  ReplayScore score_of(std::size_t replay, const sweep::JobResult& job) const;
  void sum_up(const std::vector<ReplayScore>& results);

  TuningTask task_;
  const rt::ModuleTypes* types_ = nullptr;
  std::vector<std::shared_ptr<File>> files_;
  rt::GraphSpec written_;  // robot file of the first
  std::vector<SweptParam> params_;
  std::vector<SweepPoint> points_;
  std::string error_, error_module_, unit_;
  std::vector<std::string> modules_;
  std::vector<Score> scores_;
  Score recorded_;
};

}  // namespace sinew::app
