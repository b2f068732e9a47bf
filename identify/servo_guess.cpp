#include <algorithm>

#include "identify/dense.hpp"
#include "identify/servo_fit.hpp"
#include "identify/smoothing.hpp"

namespace sinew::identify {
namespace {

constexpr double kSlow_radps = 0.05;

struct Instant {
  double time_s = 0;
  LocalMotion motion;  // other: effort
};

double target_at(const CommandLine& line, double t) {
  const auto after = std::upper_bound(line.time_s.begin(), line.time_s.end(), t) - line.time_s.begin();
  return after == 0 ? math::kNan : line.target_rad[static_cast<std::size_t>(after) - 1];
}

std::vector<Instant> instants_of(const ServoRecord& r, bool with_effort) {
  std::vector<Instant> all;
  const double period = (r.time_s.back() - r.time_s.front()) / static_cast<double>(r.time_s.size());
  const double window = std::max(2 * period, 0.01);
  std::vector<double> none;
  for (double t = r.time_s.front(); t < r.time_s.back(); t += std::max(period, 0.005)) {
    Instant i{t, {}};
    if (local_motion(r.time_s, r.position_rad, with_effort ? r.effort_nm : none, t, window, i.motion)) all.push_back(i);
  }
  return all;
}

/// Least squares of rows that `of` makes (false: no row); empty: no solution. `left`: share of the values' squares that
/// it does not explain.
template <std::size_t N, class Of>
std::vector<double> regress(const std::vector<Instant>& all, const Of& of, double& left) {
  Dense normal(N, N);
  std::vector<double> right(N);
  double square = 0, count = 0;
  for (const Instant& i : all) {
    std::array<double, N> x{};
    double y = 0;
    if (!of(i, x, y)) continue;
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t c = 0; c < N; ++c) normal(r, c) += x[r] * x[c];
      right[r] += x[r] * y;
    }
    square += y * y, count += 1;
  }
  for (std::size_t r = 0; r < N; ++r) normal(r, r) = normal(r, r) * (1 + 1e-9) + 1e-12;
  const auto solved = count > 10 * N ? solve_positive(normal, right) : std::nullopt;
  left = math::kInf;
  if (!solved || !(square > 0)) return {};
  left = 1;
  for (std::size_t r = 0; r < N; ++r) left -= (*solved)[r] * right[r] / square;
  return *solved;
}

/// Link and friction, from efforts.
void guess_load(const std::vector<Instant>& all, ServoModel& m) {
  double left = 0;
  const auto x = regress<6>(
      all,
      [](const Instant& i, std::array<double, 6>& row, double& y) {
        const LocalMotion& s = i.motion;
        const math::SinCos q = math::sincos(s.q);
        row = {s.a, s.v, s.v / (math::fabs(s.v) + kSlow_radps), -q.cos, -q.sin, 1};
        y = s.other;
        return true;
      },
      left);
  if (x.empty()) return;
  m.inertia_kgm2 = std::max(x[0], 1e-5);
  m.viscous_nms = std::max(x[1], 0.0), m.coulomb_nm = std::max(x[2], 1e-4);
  m.gravity_cos_nm = x[3], m.gravity_sin_nm = x[4], m.effort_offset_nm = x[5];
}

/// Drive and delay, from efforts: near its target the motor gives a * (target - q) - b * v, far away the most it can.
void guess_drive(const std::vector<Instant>& all, const CommandLine& commands, ServoModel& m) {
  constexpr double kNear_rad = 0.08, kFar_rad = 0.4;
  double best = math::kInf, a = 0, b = 0;
  for (int k = 0; k <= 60; ++k) {
    const double delay = 0.002 * k;
    double left = 0;
    const auto x = regress<3>(
        all,
        [&](const Instant& i, std::array<double, 3>& row, double& y) {
          const double error = target_at(commands, i.time_s - delay) - i.motion.q;
          row = {error, -i.motion.v, 1};
          y = i.motion.other;
          return math::fabs(error) < kNear_rad;
        },
        left);
    if (x.empty() || left >= best) continue;
    best = left, m.delay_s = delay, a = x[0], b = x[1];
  }
  if (!(a > 0)) return;
  b = std::max(b, 0.01 * a);
  std::vector<double> far, any;
  for (const Instant& i : all) {
    const double drive = math::fabs(i.motion.other + b * i.motion.v);
    any.push_back(drive);
    if (math::fabs(target_at(commands, i.time_s - m.delay_s) - i.motion.q) > kFar_rad) far.push_back(drive);
  }
  std::vector<double>& drive = far.size() > 20 ? far : any;
  std::sort(drive.begin(), drive.end());
  m.stall_nm = std::max(far.size() > 20 ? drive[drive.size() / 2] : drive[drive.size() * 995 / 1000], 1e-3);
  m.gain_per_rad = a / m.stall_nm;
  m.no_load_radps = m.stall_nm / b;
}

/// Without efforts: the fastest motion, and typical shares of the stall torque.
void guess_without_efforts(const std::vector<Instant>& all, double stall_nm, ServoModel& m) {
  double fastest = 0.1;
  for (const Instant& i : all) fastest = std::max(fastest, math::fabs(i.motion.v));
  m.stall_nm = stall_nm;
  m.no_load_radps = 1.2 * fastest;
  m.inertia_kgm2 = 0.005 * stall_nm, m.coulomb_nm = 0.03 * stall_nm, m.viscous_nms = 0.002 * stall_nm;
  m.delay_s = 0.02, m.gain_per_rad = 5;
}

}  // namespace

ServoModel guess_servo(const ServoRecord& record, const ServoFitOptions& options) {
  ServoModel m;
  const bool with_effort = !record.effort_nm.empty() && !math::is_nan(record.effort_nm[record.effort_nm.size() / 2]);
  const std::vector<Instant> all = instants_of(record, with_effort);
  if (with_effort) {
    guess_load(all, m);
    guess_drive(all, record.commands, m);
  } else {
    guess_without_efforts(all, options.typical_stall_nm, m);
  }
  m.rotor_kgm2 = 0.3 * m.inertia_kgm2;
  m.slow_radps = kSlow_radps;
  for (const auto& [what, value] : options.known) m.*servo_parameters()[static_cast<std::size_t>(what)].value = value;
  return m;
}

}  // namespace sinew::identify
