#include "dataset/ground_truth.hpp"

#include <algorithm>
#include <cmath>

#include "dataset/dataset_folder.hpp"

namespace sinew::dataset {

hal::Result<GroundTruth> GroundTruth::open(const std::string& folder, std::string& why) {
  for (const char* name : {"/groundtruth.csv", "/mav0/state_groundtruth_estimate0/data.csv"}) {
    std::string text;
    if (!read_file(folder + name, text, why)) {
      if (why.empty()) continue;  // there is none
      return hal::Error{hal::Errc::io, "GroundTruth::open"};
    }
    std::vector<GroundTruthSample> samples;
    if (!parse_ground_truth_csv(text, folder + name, samples, why))
      return hal::Error{hal::Errc::bad_data, "GroundTruth::open"};
    return GroundTruth(std::move(samples));
  }
  why = folder + ": no groundtruth.csv and no mav0/state_groundtruth_estimate0/data.csv";
  return hal::Error{hal::Errc::not_found, "GroundTruth::open"};
}

namespace {

msg::Vec3 mix(const msg::Vec3& a, const msg::Vec3& b, double s) {
  return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
}

/// Along the shorter way; samples are close together, so a line is good enough instead of the arc.
msg::Quat mix(const msg::Quat& a, const msg::Quat& b, double s) {
  const double dot = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z, t = dot < 0 ? -s : s;
  msg::Quat q{(1 - s) * a.w + t * b.w, (1 - s) * a.x + t * b.x, (1 - s) * a.y + t * b.y, (1 - s) * a.z + t * b.z};
  const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / n, q.x / n, q.y / n, q.z / n};
}

}  // namespace

bool GroundTruth::at(std::int64_t stamp_ns, GroundTruthSample& out) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp_ns,
                                      [](const GroundTruthSample& s, std::int64_t t) { return s.stamp_ns < t; });
  if (after == samples_.end()) return false;
  if (after->stamp_ns == stamp_ns) {
    out = *after;
    return true;
  }
  if (after == samples_.begin()) return false;
  const GroundTruthSample &a = *(after - 1), &b = *after;
  const double s = static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  out = {stamp_ns,
         mix(a.p_world_m, b.p_world_m, s),
         mix(a.v_world_mps, b.v_world_mps, s),
         mix(a.q_world_base, b.q_world_base, s),
         mix(a.gyro_bias_radps, b.gyro_bias_radps, s),
         mix(a.accel_bias_mps2, b.accel_bias_mps2, s)};
  return true;
}

}  // namespace sinew::dataset
