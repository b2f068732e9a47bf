// A real vehicle's IMU with ground truth: the folder of a EuRoC/ASL sequence (or its flat form) named by SINEW_DATA.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "control/nav_estimator.hpp"

namespace sinew::control::real_imu_test {
namespace {

using math::Quat;
using math::Vec3;

struct Row {
  std::int64_t ns = 0;
  std::vector<double> values;
};

std::vector<Row> read_table(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::string cell;
    Row row;
    std::getline(cells, cell, ',');
    row.ns = std::strtoll(cell.c_str(), nullptr, 10);
    while (std::getline(cells, cell, ',')) row.values.push_back(std::strtod(cell.c_str(), nullptr));
    rows.push_back(row);
  }
  return rows;
}

struct Recording {
  std::vector<Row> imu, truth;
};

/// Empty when there is no folder to read.
std::optional<Recording> load() {
  const char* folder = std::getenv("SINEW_DATA");
  if (!folder) return std::nullopt;
  const std::filesystem::path root(folder);
  const bool flat = std::filesystem::exists(root / "imu0.csv");
  Recording r{read_table(flat ? root / "imu0.csv" : root / "mav0/imu0/data.csv"),
              read_table(flat ? root / "groundtruth.csv" : root / "mav0/state_groundtruth_estimate0/data.csv")};
  if (r.imu.empty() || r.truth.empty()) return std::nullopt;
  return r;
}

struct TiltError {
  double rms_deg = 0, max_deg = 0;
  msg::NavState end;
};

/// Runs the estimator from `start_s` on and compares "up" from 5 s after that on.
TiltError run_from(const Recording& recording, double start_s) {
  const std::int64_t start_ns = recording.imu.front().ns + static_cast<std::int64_t>(start_s * 1e9);
  NavEstimator nav;
  std::size_t at = 0;
  double sum = 0, worst = 0;
  int count = 0;
  for (const Row& row : recording.imu) {
    if (row.ns < start_ns) continue;
    msg::ImuSample s;
    s.stamp = {row.ns};
    s.gyro_radps = {row.values[0], row.values[1], row.values[2]};
    s.accel_mps2 = {row.values[3], row.values[4], row.values[5]};
    EXPECT_TRUE(nav.add_imu(s));
    while (at + 1 < recording.truth.size() && recording.truth[at + 1].ns <= row.ns) ++at;
    const Row& truth = recording.truth[at];
    if (row.ns - start_ns < 5'000'000'000 || row.ns - truth.ns > 3'000'000) continue;
    const Vec3 up{0, 0, 1};
    const Quat q(truth.values[3], truth.values[4], truth.values[5], truth.values[6]);
    const Vec3 real = q.conjugate().rotate(up), seen = nav.filter().state().q_world_base.conjugate().rotate(up);
    const double error_deg = 180 / math::kPi * math::atan2(norm(cross(real, seen)), dot(real, seen));
    sum += error_deg * error_deg;
    worst = std::max(worst, error_deg);
    ++count;
  }
  EXPECT_GT(count, 100);
  return {math::sqrt(sum / count), worst, nav.output()};
}

class RealImu : public ::testing::TestWithParam<int> {};

TEST_P(RealImu, TiltIsBelowTwoDegreesWithUnknownBiasAlsoFromMidFlight) {
  const auto recording = load();
  if (!recording) GTEST_SKIP() << "SINEW_DATA names no folder with imu0.csv and groundtruth.csv";
  const TiltError e = run_from(*recording, GetParam());
  RecordProperty("rms_mdeg", static_cast<int>(1000 * e.rms_deg));
  std::cout << "start " << GetParam() << " s: tilt error " << e.rms_deg << " deg RMS, " << e.max_deg << " at most\n";
  EXPECT_LT(e.rms_deg, 2.0);
  EXPECT_TRUE(e.end.attitude_valid);
  EXPECT_FALSE(e.end.position_valid) << "nothing has aided it";
  EXPECT_LT(norm(Vec3(e.end.v_world_mps)), 3);
}
INSTANTIATE_TEST_SUITE_P(StartAtSecond, RealImu, ::testing::Values(0, 5, 10, 15, 20, 25, 30, 35, 40));

}  // namespace
}  // namespace sinew::control::real_imu_test
