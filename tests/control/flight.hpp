#pragma once
// A whole flight without executor and camera: the pure classes in the order in which the robot file runs the modules.
// Sightings of the pad come from truth, with noise, a limited field of view and 40 ms of delay.
#include <deque>
#include <functional>
#include <vector>

#include "control/attitude_law.hpp"
#include "control/nav_estimator.hpp"
#include "control/position_law.hpp"
#include "control/rotor_allocation.hpp"
#include "math/hash.hpp"
#include "robots/quad/mission_plan.hpp"
#include "test_world.hpp"

namespace sinew::control::test {

struct FlightReport {
  msg::MissionPhase phase = msg::MissionPhase::wait;
  std::vector<msg::MissionPhase> phases;
  double end_s = 0, worst_pad_distance_error_m = 0, worst_tilt_error_rad = 0, max_tilt_rad = 0;
  double end_pad_distance_m = 0, end_speed_mps = 0, touch_speed_mps = 0;
  NavEstimator::Counters counters;
  std::uint64_t hash = 0;
};

class Flight {
 public:
  NavEstimator nav;
  MissionPlan mission;
  PositionLaw position;
  AttitudeLaw attitude;
  RotorParams rotors;
  math::Vec3 pad_world_m;
  double pad_visible_from_s = 0, pad_visible_until_s = 1e9;
  double range_until_s = 1e9, baro_until_s = 1e9;
  double pad_noise = 0.004;  // of the direction
  std::size_t command_delay_ms = 0;
  std::int64_t pad_delay_ns = 40'000'000;
  void (*trace)(const Flight&, double t_s) = nullptr;
  std::function<msg::PadSighting(msg::Time)> look;  // instead of the sightings made from truth

  Flight(TestWorld& world, std::uint64_t seed) : world_(world), noise_(seed, 77) {}
  const TestWorld& world() const { return world_; }
  const msg::NavState& nav_state() const { return nav_state_; }

  /// Until one second after the end of the mission, or the limit.
  FlightReport run(double limit_s) {
    FlightReport report;
    double done_s = 1e9, fall_mps = 0;
    std::int64_t frame = 1;
    for (double t_s = 0; t_s < limit_s && t_s < done_s + 1;) {
      const Samples s = world_.step(commands_.size() > command_delay_ms ? commands_.front() : kStopped);
      t_s = msg::seconds(s.now);
      if (s.now.ns >= frame * 100'000'000 / 3) {
        frame = frame + 1;
        sight(s.now, t_s);
      }
      const Truth truth = world_.truth();
      if (truth.p_world_m.z < 0.125 && fall_mps < 0) report.touch_speed_mps = -fall_mps;
      fall_mps = truth.v_world_mps.z;
      if (s.range && t_s < range_until_s) nav.add_range(*s.range);
      if (s.baro && t_s < baro_until_s) nav.add_baro(*s.baro);
      if (!s.imu || !stabilise(s, report)) continue;
      judge(truth, report);
      if (trace) trace(*this, t_s);
      if (mission.state().phase == msg::MissionPhase::done) done_s = std::min(done_s, t_s);
    }
    const Truth truth = world_.truth();
    const math::Vec3 away = truth.p_world_m - pad_world_m;
    report.end_pad_distance_m = math::hypot(away.x, away.y);
    report.end_speed_mps = norm(truth.v_world_mps);
    report.phase = mission.state().phase;
    report.end_s = done_s;
    report.counters = nav.counters();
    report.hash = hash_.value();
    return report;
  }

 private:
  static constexpr std::array<double, 4> kStopped{};
  bool stabilise(const Samples& s, FlightReport& report) {
    nav.set_motors_stopped(commands_.empty() || commands_.back()[0] == 0);
    nav.add_imu(*s.imu);
    for (; !pads_.empty() && pads_.front().stamp.ns + pad_delay_ns <= s.now.ns; pads_.pop_front()) {
      nav.add_pad(pads_.front());
    }
    if (!nav.started()) return false;
    nav_state_ = nav.output();
    hash_.add(&nav_state_, sizeof nav_state_);
    if (nav_state_.attitude_valid && s.now.ns % 5'000'000 == 0) {  // 200 Hz
      mission.step(s.now, nav_state_, 0.005);
      attitude_wanted_ = position.step(nav_state_, mission.setpoint(), 0.005);
      if (report.phases.empty() || report.phases.back() != mission.state().phase) {
        report.phases.push_back(mission.state().phase);
      }
    }
    const msg::WrenchSetpoint wrench = attitude.step(nav_state_, attitude_wanted_, 0.001);
    std::array<double, 4> command{};
    if (wrench.armed) command = allocate(math::Vec3(wrench.torque_nm), wrench.thrust_n, rotors).command;
    hash_.add(command.data(), sizeof command);
    commands_.push_back(command);
    if (commands_.size() > command_delay_ms + 1) commands_.pop_front();
    return true;
  }
  void sight(msg::Time stamp, double t_s) {
    if (look) return pads_.push_back(look(stamp));
    const Truth truth = world_.truth();
    const math::Vec3 camera = truth.p_world_m + truth.q_world_base.rotate(world_.p_base_camera);
    const math::Vec3 to_pad = truth.q_world_base.conjugate().rotate(pad_world_m - camera);
    const math::Vec3 seen = world_.q_base_optical.conjugate().rotate(to_pad);
    const double nx = noise_.normal(0, pad_noise), ny = noise_.normal(0, pad_noise);
    msg::PadSighting s;
    s.stamp = stamp;
    const bool in_view =
        seen.z > 0.12 && math::fabs(seen.x / seen.z) < 160.0 / 210 && math::fabs(seen.y / seen.z) < 120.0 / 210;
    if (in_view && t_s > pad_visible_from_s && t_s < pad_visible_until_s) {
      s.direction_optical = normalized(math::Vec3{seen.x / seen.z + nx, seen.y / seen.z + ny, 1}).to<msg::Vec3>();
      s.found = 1;
      s.confidence = 0.9;
    }
    pads_.push_back(s);
  }
  void judge(const Truth& truth, FlightReport& report) const {
    const auto angle = [](const math::Vec3& a, const math::Vec3& b) {
      return math::atan2(norm(cross(a, b)), dot(a, b));
    };
    const math::Vec3 up{0, 0, 1}, up_true = truth.q_world_base.conjugate().rotate(up);
    const math::Vec3 up_seen = math::Quat(nav_state_.q_world_base).conjugate().rotate(up);
    report.max_tilt_rad = std::max(report.max_tilt_rad, angle(up, up_true));
    report.worst_tilt_error_rad = std::max(report.worst_tilt_error_rad, angle(up_true, up_seen));
    if (!nav_state_.pad_known) return;
    // Distances from the pad: the filter's axes are turned by the yaw of the start.
    const math::Vec3 seen = math::Vec3(nav_state_.p_world_m) - math::Vec3(nav_state_.pad_world_m);
    const math::Vec3 real = truth.p_world_m - pad_world_m;
    const double e = math::fabs(math::hypot(seen.x, seen.y) - math::hypot(real.x, real.y));
    report.worst_pad_distance_error_m = std::max(report.worst_pad_distance_error_m, e);
  }

  TestWorld& world_;
  math::Random noise_;
  math::Hash64 hash_;
  std::deque<msg::PadSighting> pads_;
  msg::NavState nav_state_;
  msg::AttitudeSetpoint attitude_wanted_;
  std::deque<std::array<double, 4>> commands_;  // the oldest acts, the newest is the last one given
};

}  // namespace sinew::control::test
