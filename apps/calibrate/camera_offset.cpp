#include "apps/calibrate/camera_offset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"

namespace sinew::app {
namespace {

using math::Mat;
using math::Quat;
using math::Vec3;

constexpr std::size_t kFewestPairs = 100;         // some 3 s of pictures
constexpr double kLeastRate_radps = 0.03;         // RMS about each axis
constexpr double kLeastExplained = 0.6;           // of the pictures' turns, by the gyro
constexpr double kCoarse_ms = 2, kFine_ms = 0.5;  // steps of the delay
constexpr double kOutlier = 4;                    // times the RMS residual
constexpr double kLongestGap_s = 0.012;           // between IMU samples: in a longer gap the rate may have reversed
constexpr double kLongestPair_s = 0.2;            // between two pictures of a pair
constexpr double kRad = math::kPi / 180;

}  // namespace

/// Of all turns at one delay: rotation = map * turn by the gyro + bias * time.
struct CameraOffset::Fit {
  math::Mat3 map = math::Mat3::identity();
  Vec3 bias_radps;
  double squares = 0, total = 0;  // of the residuals; of the rotations
  Vec3 excitation_radps;          // RMS rate about each optical axis, without the part that the other axes predict
  double seconds = 0;
  std::size_t used = 0;
  std::vector<double> residual;  // of each pair; negative: the IMU does not cover the pair
};

void CameraOffset::add(const msg::ImuSample& s) {
  const Vec3 rate(s.gyro_radps);
  Turned next{s.stamp, {}, 0};
  if (!turned_.empty()) {
    const Turned& before = turned_.back();
    const double dt = msg::seconds(s.stamp - before.at);
    if (dt <= 0) return;
    next.angle_rad = before.angle_rad + 0.5 * dt * (last_radps_ + rate);
    next.stretch = before.stretch + (dt > kLongestGap_s ? 1 : 0);
  }
  turned_.push_back(next);
  last_radps_ = rate;
}

void CameraOffset::add(msg::Time older, msg::Time newer, const Vec3& rotation_rad) {
  const double dt = msg::seconds(newer - older);
  if (dt > 0 && dt < kLongestPair_s) pairs_.push_back({older, newer, rotation_rad});
}

std::optional<CameraOffset::Turned> CameraOffset::turned_by(double at_ns) const {
  const auto after = std::lower_bound(turned_.begin(), turned_.end(), at_ns,
                                      [](const Turned& t, double ns) { return static_cast<double>(t.at.ns) < ns; });
  if (after == turned_.begin() || after == turned_.end()) return std::nullopt;
  const Turned &a = *(after - 1), &b = *after;
  if (a.stretch != b.stretch) return std::nullopt;
  const double share = (at_ns - static_cast<double>(a.at.ns)) / static_cast<double>((b.at - a.at).count());
  return Turned{{static_cast<std::int64_t>(at_ns)}, a.angle_rad + share * (b.angle_rad - a.angle_rad), a.stretch};
}

CameraOffset::Fit CameraOffset::fit(const std::vector<Pair>& pairs, const Quat& q, double offset_ms) const {
  Fit f;
  Mat<4, 4> normal;
  Mat<4, 3> right;
  std::vector<std::array<double, 4>> rows(pairs.size());
  f.residual.assign(pairs.size(), -1);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& p = pairs[i];
    const auto from = turned_by(static_cast<double>(p.older.ns) + 1e6 * offset_ms);
    const auto to = turned_by(static_cast<double>(p.newer.ns) + 1e6 * offset_ms);
    if (!from || !to || from->stretch != to->stretch) continue;
    const Vec3 by = q.conjugate().rotate(to->angle_rad - from->angle_rad);
    const double dt = msg::seconds(p.newer - p.older);
    rows[i] = {by.x, by.y, by.z, dt};
    f.residual[i] = 0;
    ++f.used;
    f.seconds += dt;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) normal(a, b) += rows[i][a] * rows[i][b];
      for (int b = 0; b < 3; ++b) right(a, b) += rows[i][a] * p.rotation_rad[b];
    }
  }
  const auto solved = math::solve(normal, right);
  const auto spread = math::inverse(normal);
  if (!solved || !spread) return f;
  for (int a = 0; a < 3; ++a)
    f.excitation_radps[a] = std::sqrt(static_cast<double>(f.used) / (*spread)(a, a)) / f.seconds;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) f.map(a, b) = (*solved)(b, a);
    f.bias_radps[a] = (*solved)(3, a);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (f.residual[i] < 0) continue;
    const Vec3 by{rows[i][0], rows[i][1], rows[i][2]}, seen = pairs[i].rotation_rad - rows[i][3] * f.bias_radps;
    f.residual[i] = squared_norm(seen - f.map * by);
    f.squares += f.residual[i];
    f.total += squared_norm(seen);
  }
  return f;
}

double CameraOffset::best_offset_ms(const std::vector<Pair>& pairs, const Quat& q) const {
  const auto search = [&](double from, double to, double step) {
    double best = from, least = -1;
    for (double ms = from; ms <= to; ms += step) {
      const Fit f = fit(pairs, q, ms);
      const double mean = f.squares / static_cast<double>(std::max<std::size_t>(f.used, 1));
      if (f.used > 0 && (least < 0 || mean < least)) best = ms, least = mean;
    }
    return best;
  };
  const double near = search(-kMostOffset_ms, kMostOffset_ms, kCoarse_ms);
  const double best = search(near - kCoarse_ms, near + kCoarse_ms, kFine_ms);
  // The least of a parabola through three neighbours.
  const auto mean_at = [&](double ms) {
    const Fit f = fit(pairs, q, ms);
    return f.squares / static_cast<double>(std::max<std::size_t>(f.used, 1));
  };
  const double a = mean_at(best - kFine_ms), b = mean_at(best), c = mean_at(best + kFine_ms);
  const double bend = a - 2 * b + c;
  return bend > 0 ? best + std::clamp(0.5 * (a - c) / bend, -1.0, 1.0) * kFine_ms : best;
}

/// Pairs whose whole search range the IMU covers without a gap, so that the same pairs judge every delay.
std::vector<CameraOffset::Pair> CameraOffset::usable() const {
  std::vector<Pair> kept;
  for (const Pair& p : pairs_) {
    const auto from = turned_by(static_cast<double>(p.older.ns) - 1e6 * kMostOffset_ms);
    const auto to = turned_by(static_cast<double>(p.newer.ns) + 1e6 * kMostOffset_ms);
    if (from && to && from->stretch == to->stretch) kept.push_back(p);
  }
  return kept;
}

std::optional<CameraOffset::Result> CameraOffset::solve(const Quat& q_nominal, std::string& why) const {
  std::vector<Pair> pairs = usable();
  if (pairs.size() < kFewestPairs) {
    why = fmt::format("only {} pairs of pictures with gyro rates around them without a gap, {} are needed",
                      pairs.size(), kFewestPairs);
    return std::nullopt;
  }
  Result r;
  r.excitation_radps = fit(pairs, q_nominal, 0).excitation_radps;
  for (int a = 0; a < 3; ++a)
    if (!(r.excitation_radps[a] > kLeastRate_radps)) {
      why = fmt::format("it was turned too little about the camera's {} axis: {:.3f} rad/s RMS, {} are needed",
                        a == 0   ? "right"
                        : a == 1 ? "down"
                                 : "forward",
                        r.excitation_radps[a], kLeastRate_radps);
      return std::nullopt;
    }
  Quat q = q_nominal;
  Fit f;
  for (int round = 0; round < 6; ++round) {
    r.time_offset_ms = best_offset_ms(pairs, q);
    f = fit(pairs, q, r.time_offset_ms);
    // The camera sees the gyro's turn in its own frame: v - theta x v for a camera that is turned by theta.
    r.scale = 0.5 * (f.map(0, 0) + f.map(1, 1));
    const Vec3 theta{-f.map(2, 1) / f.map(2, 2), f.map(2, 0) / f.map(2, 2),
                     0.5 * (f.map(0, 1) - f.map(1, 0)) / r.scale};
    if (!math::is_finite(theta) || norm(theta) > 30 * kRad) break;
    q = (q * Quat::exp(theta)).normalized();
    const double limit = kOutlier * kOutlier * f.squares / static_cast<double>(f.used);
    std::vector<Pair> kept;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (f.residual[i] >= 0 && f.residual[i] <= limit) kept.push_back(pairs[i]);
    if (kept.size() > pairs.size() / 2) pairs = std::move(kept);
  }
  f = fit(pairs, q, r.time_offset_ms);
  const double explained = 1 - f.squares / f.total;
  if (!(explained > kLeastExplained) || std::abs(r.time_offset_ms) > kMostOffset_ms - kCoarse_ms) {
    why = fmt::format(
        "the pictures do not turn as the gyro does (only {:.0f} % of it fits at any delay within {} ms): "
        "too little texture, something large that moves, another camera, or a mount that is off by more "
        "than 30 degrees",
        100 * std::max(explained, 0.0), kMostOffset_ms);
    return std::nullopt;
  }
  const double turned = norm((q_nominal.conjugate() * q).log());
  if (!(turned < 30 * kRad)) {
    why = fmt::format("the mount came out {:.0f} degrees off the robot file's: correct that first", turned / kRad);
    return std::nullopt;
  }
  r.q_imu_optical = q;
  r.turned_deg = (q_nominal.conjugate() * q).log() / kRad;
  r.pairs = f.used;
  r.residual_radps = std::sqrt(f.squares / 3 / f.seconds / f.seconds * static_cast<double>(f.used));
  const double h = 2, bend = fit(pairs, q, r.time_offset_ms - h).squares - 2 * f.squares +
                             fit(pairs, q, r.time_offset_ms + h).squares;
  r.time_sigma_ms = bend > 0 ? std::sqrt(2 * f.squares / static_cast<double>(3 * f.used) / (bend / (h * h))) : 0;
  return r;
}

}  // namespace sinew::app
