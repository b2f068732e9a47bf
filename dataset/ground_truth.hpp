#pragma once
#include <string>
#include <vector>

#include "dataset/dataset_files.hpp"
#include "hal/result.hpp"

namespace sinew::dataset {

/// The true motion that came with a dataset. For the run's report only; no module ever sees it.
/// Thread:  owner.
class GroundTruth {
 public:
  /// Reads `groundtruth.csv` or `mav0/state_groundtruth_estimate0/data.csv` of the folder.
  /// Errors:  not_found when there is none; bad_data, with "file:line: what is wrong" in `why`.
  static hal::Result<GroundTruth> open(const std::string& folder, std::string& why);
  explicit GroundTruth(std::vector<GroundTruthSample> samples) : samples_(std::move(samples)) {}

  const std::vector<GroundTruthSample>& samples() const { return samples_; }
  /// Between two samples by interpolation; false outside of the record. Stamps are the dataset's: see
  /// DatasetBoard::dataset_stamp().
  bool at(std::int64_t stamp_ns, GroundTruthSample& out) const;

 private:
  std::vector<GroundTruthSample> samples_;
};

}  // namespace sinew::dataset
