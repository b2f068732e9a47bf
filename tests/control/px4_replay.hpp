#pragma once
// A flight in the format of PX4's EKF2 replay tests, through NavEstimator, beside what EKF2 made of it.
// One sample a line: time_us,type,values (imu, mag, baro, landed, gps; axes forward-right-down and north-east-down).
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "control/nav_estimator.hpp"

namespace sinew::control::test {

struct Px4Sample {
  std::int64_t us = 0;
  std::string type;
  std::vector<double> values;
};

/// One line of EKF2's own output: 24 states and their variances; axes as it has them.
struct Ekf2Line {
  std::int64_t us = 0;
  std::vector<double> state, variance;
};

struct Px4Flight {
  std::vector<Px4Sample> samples;
  std::vector<Ekf2Line> ekf2;
};

inline std::vector<double> numbers_of(std::istringstream& cells) {
  std::vector<double> all;
  for (std::string cell; std::getline(cells, cell, ',');) all.push_back(std::strtod(cell.c_str(), nullptr));
  return all;
}

/// Nothing when the files are not there or an unknown kind of line is in them.
inline std::optional<Px4Flight> read_px4_flight(const std::filesystem::path& folder) {
  Px4Flight flight;
  std::ifstream samples(folder / "ekf_gsf_reset.csv"), ekf2(folder / "ekf_gsf_reset.ekf2.csv");
  for (std::string line; std::getline(samples, line);) {
    std::istringstream cells(line);
    std::string time, type;
    std::getline(cells, time, ',');
    std::getline(cells, type, ',');
    Px4Sample s{std::strtoll(time.c_str(), nullptr, 10), type, numbers_of(cells)};
    const std::size_t wanted = type == "imu" || type == "gps" ? 6 : type == "mag" ? 3 : 1;
    if (s.values.size() != wanted) return std::nullopt;
    flight.samples.push_back(std::move(s));
  }
  std::string line;
  std::getline(ekf2, line);  // names
  while (std::getline(ekf2, line)) {
    std::istringstream cells(line);
    std::string time;
    std::getline(cells, time, ',');
    std::vector<double> all = numbers_of(cells);
    if (all.size() != 48) return std::nullopt;
    flight.ekf2.push_back(
        {std::strtoll(time.c_str(), nullptr, 10), {all.begin(), all.begin() + 24}, {all.begin() + 24, all.end()}});
  }
  if (flight.samples.empty() || flight.ekf2.empty()) return std::nullopt;
  return flight;
}

inline math::Vec3 flipped(const double* frd) { return {frd[0], -frd[1], -frd[2]}; }
inline math::Vec3 enu(const double* ned) { return {ned[1], ned[0], -ned[2]}; }

/// EKF2's quaternion (forward-right-down to north-east-down) as ours (forward-left-up to east-north-up).
inline math::Quat q_world_base(const Ekf2Line& l) {
  const math::Mat3 r = math::Quat{l.state[0], l.state[1], l.state[2], l.state[3]}.matrix();
  const math::Mat3 swap{0, 1, 0, 1, 0, 0, 0, 0, -1}, flip{1, 0, 0, 0, -1, 0, 0, 0, -1};
  return math::Quat::from_matrix(swap * r * flip);
}

struct ReplayOptions {
  bool mag = true;
  double gnss_delay_s = 0;
  std::function<void(Px4Sample&)> change;  // of each sample, before it is used
};

/// One GNSS fix as the estimator foretold it, before it was used.
struct FixInnovation {
  std::int64_t us = 0;
  math::Vec3 v_mps, p_m;
};

/// The estimate after one inertial sample.
struct ReplayLine {
  std::int64_t us = 0;
  InertialState state;
  double heading_std_rad = 0;
  math::Vec3 v_std_mps, p_std_m;
  bool heading_valid = false;
};

struct Replay {
  std::vector<ReplayLine> lines;  // every 25th inertial sample: 10 Hz
  std::vector<FixInnovation> innovations;
  std::vector<msg::NavReport> resets;
  msg::NavReport last;
  LocalFrame frame;
};

/// `p_m` in the estimator's world.
inline msg::GnssSample gnss_of(const Px4Sample& s) {
  msg::GnssSample g;
  g.stamp = {s.us * 1000};
  g.altitude_m = s.values[0] * 1e-3;
  g.longitude_deg = s.values[1] * 1e-7;
  g.latitude_deg = s.values[2] * 1e-7;
  g.velocity_mps = enu(&s.values[3]).to<msg::Vec3>();
  g.horizontal_accuracy_m = g.vertical_accuracy_m = g.speed_accuracy_mps = math::kNan;
  g.fix = msg::GnssFix::full;
  return g;
}

inline Replay replay(const Px4Flight& flight, const ReplayOptions& o) {
  Replay out;
  NavEstimator nav;
  nav.params.outdoors.gnss_delay_s = o.gnss_delay_s;
  nav.params.accel_limit_mps2 = 200;
  int imu_count = 0;
  for (Px4Sample s : flight.samples) {
    if (o.change) o.change(s);
    const double* v = s.values.data();
    const msg::Time stamp{s.us * 1000};
    if (s.type == "imu") {
      msg::ImuSample m;
      m.stamp = stamp;
      m.accel_mps2 = flipped(v).to<msg::Vec3>();
      m.gyro_radps = flipped(v + 3).to<msg::Vec3>();
      nav.add_imu(m);
      if (nav.started() && ++imu_count % 25 == 0) {
        const Covariance& p = nav.filter().covariance();
        const auto sigma = [&](int i) {
          return math::Vec3{math::sqrt(p.variance(i)), math::sqrt(p.variance(i + 1)), math::sqrt(p.variance(i + 2))};
        };
        out.lines.push_back({s.us, nav.filter().state(), nav.heading_std_rad(), sigma(kErrV), sigma(kErrP),
                             nav.report().heading_valid != 0});
      }
    } else if (s.type == "mag" && o.mag) {
      msg::MagSample m;
      m.stamp = stamp;
      m.field_t = (flipped(v) * 1e-4).to<msg::Vec3>();
      nav.add_mag(m);
    } else if (s.type == "baro") {
      msg::BaroSample m;
      m.stamp = stamp;
      m.temperature_c = 15;
      m.pressure_pa = 101325 * math::exp(-v[0] / (29.2718 * 288.15));
      nav.add_baro(m);
    } else if (s.type == "landed") {
      nav.set_motors_stopped(v[0] != 0);
    } else if (s.type == "gps") {
      const msg::GnssSample g = gnss_of(s);
      const auto then = nav.pose_at({g.stamp.ns - static_cast<std::int64_t>(o.gnss_delay_s * 1e9)});
      if (then && nav.frame().known()) {
        const math::Vec3 p = nav.frame().to_world({g.latitude_deg, g.longitude_deg, g.altitude_m});
        out.innovations.push_back({s.us, math::Vec3(g.velocity_mps) - then->v_world_mps, p - then->p_world_m});
      }
      nav.add_gnss(g);
    }
    const std::uint32_t before = out.last.resets;
    if (msg::NavReport r; nav.take_report(r)) {
      if (r.resets != before) out.resets.push_back(r);
      out.last = r;
    }
  }
  out.frame = nav.frame();
  return out;
}

/// EKF2's states at an instant, between two of its lines.
inline std::optional<Ekf2Line> ekf2_at(const Px4Flight& flight, std::int64_t us) {
  for (std::size_t i = 0; i + 1 < flight.ekf2.size(); ++i) {
    const Ekf2Line &a = flight.ekf2[i], &b = flight.ekf2[i + 1];
    if (us < a.us || us >= b.us) continue;
    Ekf2Line l = a;
    const double s = static_cast<double>(us - a.us) / static_cast<double>(b.us - a.us);
    l.us = us;
    for (std::size_t k = 0; k < l.state.size(); ++k) {
      l.state[k] += (b.state[k] - a.state[k]) * s;
      l.variance[k] += (b.variance[k] - a.variance[k]) * s;
    }
    return l;
  }
  return std::nullopt;
}

/// Horizontal root mean squares from `from_s` on.
struct Innovations {
  double v_mps = 0, p_m = 0;
  int fixes = 0;
};

inline Innovations innovations_of(const Replay& r, double from_s) {
  Innovations sum;
  for (const FixInnovation& i : r.innovations) {
    if (static_cast<double>(i.us) < from_s * 1e6) continue;
    sum.v_mps += i.v_mps.x * i.v_mps.x + i.v_mps.y * i.v_mps.y;
    sum.p_m += i.p_m.x * i.p_m.x + i.p_m.y * i.p_m.y;
    ++sum.fixes;
  }
  return {math::sqrt(sum.v_mps / sum.fixes), math::sqrt(sum.p_m / sum.fixes), sum.fixes};
}

/// Of EKF2's own output, `shift_s` later than the fix. Its lines are 0.1 s apart and between two of them it is
/// interpolated, so the fix itself may be in it already: in its favour. Its position is moved to the fixes' mean on the
/// ground first: its origin is its own.
inline Innovations ekf2_innovations(const Px4Flight& flight, const LocalFrame& frame, double from_s, double shift_s) {
  Innovations sum;
  math::Vec3 origin;
  int on_ground = 0;
  for (const bool counts : {false, true}) {
    for (const Px4Sample& s : flight.samples) {
      const bool ground = s.us > 10'000'000 && s.us < 20'000'000;
      if (s.type != "gps" || (!counts && !ground) || (counts && static_cast<double>(s.us) < from_s * 1e6)) continue;
      const auto l = ekf2_at(flight, s.us + static_cast<std::int64_t>(shift_s * 1e6));
      if (!l) continue;
      const msg::GnssSample g = gnss_of(s);
      const math::Vec3 p = frame.to_world({g.latitude_deg, g.longitude_deg, g.altitude_m}) - enu(&l->state[7]) - origin;
      if (!counts) {
        ++on_ground;
        origin += p / on_ground;  // p is without the mean so far
        continue;
      }
      const math::Vec3 v = math::Vec3(g.velocity_mps) - enu(&l->state[4]);
      sum.v_mps += v.x * v.x + v.y * v.y;
      sum.p_m += p.x * p.x + p.y * p.y;
      ++sum.fixes;
    }
  }
  return {math::sqrt(sum.v_mps / sum.fixes), math::sqrt(sum.p_m / sum.fixes), sum.fixes};
}

/// At the delay that suits EKF2's output best.
inline Innovations best_ekf2_innovations(const Px4Flight& flight, const LocalFrame& frame, double from_s) {
  Innovations best{1e9, 1e9, 0};
  for (int i = -20; i <= 20; ++i) {
    const Innovations n = ekf2_innovations(flight, frame, from_s, 0.01 * i);
    best = {std::min(best.v_mps, n.v_mps), std::min(best.p_m, n.p_m), n.fixes};
  }
  return best;
}

}  // namespace sinew::control::test
