// A flight recorded in PX4's simulator (format of its EKF2 replay tests) through NavEstimator, beside EKF2's own
// output: a table, and a plot. usage: px4_replay FOLDER [PLOT.svg]     FOLDER has ekf_gsf_reset.csv and
// ekf_gsf_reset.ekf2.csv
#include <cstdio>

#include "apps/view/plot.hpp"
#include "px4_replay.hpp"

namespace {

using namespace sinew;
using namespace sinew::control::test;

constexpr double kDelay_s = 0.1, kLiftOff_s = 23;
constexpr double kDegree = math::kPi / 180;

double seconds(std::int64_t us) { return 1e-6 * static_cast<double>(us); }
/// EKF2's output is the state of 0.1 s before its line.
constexpr std::int64_t kEkf2Late_us = 100'000;

std::vector<app::Plot> plots_of(const Px4Flight& flight, const Replay& with, const Replay& without) {
  app::Plot heading{"Heading, counter-clockwise from east", "s", "deg", {}, {}, {}, {}};
  app::Plot speed{"Velocity to the north", "s", "m/s", {}, {}, {}, {}};
  app::Plot place{"Position to the north, from the start", "s", "m", {}, {}, {}, {}};
  app::Plot sigma{"Stated uncertainty of the horizontal velocity (1 sigma)", "s", "m/s", {}, {}, {}, {}};
  for (app::Plot* p : {&heading, &speed, &place, &sigma}) p->series.resize(3);
  const char* const names[] = {"ours", "ours, no magnetometer", "EKF2"};
  for (app::Plot* p : {&heading, &speed, &place, &sigma})
    for (std::size_t i = 0; i < 3; ++i) p->series[i].name = names[i];
  std::size_t k = 0;
  for (const Replay* r : {&with, &without}) {
    for (const ReplayLine& l : r->lines) {
      const double t = seconds(l.us);
      if (k == 0 || l.heading_valid) {
        heading.series[k].points.push_back({t, l.state.q_world_base.yaw() / kDegree});
        speed.series[k].points.push_back({t, l.state.v_world_mps.y});
        place.series[k].points.push_back({t, l.state.p_world_m.y});
      }
      sigma.series[k].points.push_back({t, math::hypot(l.v_std_mps.x, l.v_std_mps.y)});
    }
    ++k;
  }
  for (const Ekf2Line& l : flight.ekf2) {
    const double t = seconds(l.us - kEkf2Late_us);
    heading.series[2].points.push_back({t, q_world_base(l).yaw() / kDegree});
    speed.series[2].points.push_back({t, l.state[4]});
    place.series[2].points.push_back({t, l.state[7]});
    sigma.series[2].points.push_back({t, math::sqrt(l.variance[4] + l.variance[5])});
  }
  app::Series fixes{"GNSS, 0.1 s before it came", {}, false};
  app::Series fix_speed = fixes;
  for (const Px4Sample& s : flight.samples) {
    if (s.type != "gps") continue;
    const msg::GnssSample g = gnss_of(s);
    const math::Vec3 p = with.frame.to_world({g.latitude_deg, g.longitude_deg, g.altitude_m});
    fixes.points.push_back({seconds(s.us) - kDelay_s, p.y});
    fix_speed.points.push_back({seconds(s.us) - kDelay_s, g.velocity_mps.y});
  }
  place.series.push_back(fixes);
  speed.series.push_back(fix_speed);
  for (const msg::NavReport& r : without.resets)
    heading.marks.push_back({msg::seconds(r.stamp), "first heading without magnetometer", false});
  heading.marks.resize(heading.marks.empty() ? 0 : 1);
  return {heading, speed, place, sigma};
}

void print_at(const Px4Flight& flight, const Replay& r, double t) {
  for (const ReplayLine& l : r.lines) {
    if (seconds(l.us) < t) continue;
    const auto e = ekf2_at(flight, l.us + kEkf2Late_us);
    if (!e) return;
    const math::YawPitchRoll a = l.state.q_world_base.yaw_pitch_roll(), b = q_world_base(*e).yaw_pitch_roll();
    const math::Vec3 v = enu(&e->state[4]), p = enu(&e->state[7]);
    // The variance of a rotation by half of each quaternion component's.
    const double e_tilt = 2 * math::sqrt(e->variance[1] + e->variance[2]), e_yaw = 2 * math::sqrt(e->variance[3]);
    std::printf(
        "| %4.1f | %7.1f +- %4.1f | %7.1f +- %4.1f | %5.1f %5.1f | %5.1f %5.1f (+- %3.1f) | %5.2f %5.2f +- %4.2f | "
        "%5.2f "
        "%5.2f +- %4.2f | %6.2f %6.2f +- %4.2f | %6.2f %6.2f +- %4.2f |\n",
        t, a.yaw / kDegree, l.heading_std_rad / kDegree, b.yaw / kDegree, e_yaw / kDegree, a.pitch / kDegree,
        a.roll / kDegree, b.pitch / kDegree, b.roll / kDegree, e_tilt / kDegree, l.state.v_world_mps.x,
        l.state.v_world_mps.y, math::hypot(l.v_std_mps.x, l.v_std_mps.y), v.x, v.y,
        math::sqrt(e->variance[4] + e->variance[5]), l.state.p_world_m.x, l.state.p_world_m.y,
        math::hypot(l.p_std_m.x, l.p_std_m.y), p.x, p.y, math::sqrt(e->variance[7] + e->variance[8]));
    return;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: px4_replay FOLDER [PLOT.svg]\n");
    return 2;
  }
  const auto flight = read_px4_flight(argv[1]);
  if (!flight) {
    std::fprintf(stderr, "px4_replay: %s: no ekf_gsf_reset.csv and ekf_gsf_reset.ekf2.csv that can be read\n", argv[1]);
    return 1;
  }
  const Replay with = replay(*flight, {.gnss_delay_s = kDelay_s, .change = {}});
  const Replay without = replay(*flight, {.mag = false, .gnss_delay_s = kDelay_s, .change = {}});
  std::printf(
      "| s | heading, deg: ours | EKF2 | pitch, roll, deg: ours | EKF2 | velocity east, north, m/s: ours | EKF2 | "
      "position east, north, m: ours | EKF2 |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const double t : {2.0, 6.0, 15.0, 24.0, 26.0, 27.0, 28.0, 29.0, 30.0, 31.0, 32.0, 33.0, 35.0, 37.0})
    print_at(*flight, with, t);
  const Innovations ours = innovations_of(with, kLiftOff_s);
  const Innovations ekf2 = best_ekf2_innovations(*flight, with.frame, kLiftOff_s);
  std::printf(
      "\nthe next fix, horizontal RMS from lift-off on (%d fixes):\n  ours  %.3f m/s  %.3f m\n  EKF2  %.3f m/s  %.3f m"
      "  (at the delay that suits it best)\n",
      ours.fixes, ours.v_mps, ours.p_m, ekf2.v_mps, ekf2.p_m);
  for (const msg::NavReport& r : without.resets)
    std::printf("without magnetometer: %.2f s: %s, %.1f deg, heading +- %.1f deg\n", msg::seconds(r.stamp),
                std::string(msg::name_of(msg::kNavResetCauseNames, static_cast<std::uint32_t>(r.reset_cause))).c_str(),
                r.reset_yaw_rad / kDegree, r.heading_std_rad / kDegree);
  if (argc < 3) return 0;
  const std::string why = app::write_plots(argv[2], plots_of(*flight, with, without));
  if (!why.empty()) std::fprintf(stderr, "px4_replay: %s\n", why.c_str());
  return why.empty() ? 0 : 1;
}
