#include "apps/gait/walk_trial.hpp"

#include <algorithm>

#include "math/random.hpp"
#include "motion/gaze.hpp"

namespace sinew::gait {
namespace {

constexpr double kStand_s = 3;
constexpr double kLookAside_rad = math::kPi / 3, kLookDown_rad = math::kPi / 9, kLookPeriod_s = 12, kWaySmooth_s = 0.3;
constexpr double kSettled_s = 1.5;  // after a change of the command its speed counts

/// What is commanded `t_s` after standing; a new stretch begins where `stretch` changes.
struct Commander {
  const WalkTrial& trial;
  const motion::WalkParams& most;
  const double side = math::Random(trial.seed, 0x51de).uniform(-1, 1) > 0 ? 1 : -1;  // 1: to the left

  motion::WalkCommand at(double t_s, int& stretch) const {
    const double share = trial.speed_share;
    motion::WalkCommand c{.walk = true};
    stretch = 0;
    switch (trial.course) {
      case Course::forward:
        c.forward_mps = trial.forward_mps.value_or(share * most.most_forward_mps);
        break;
      case Course::back:
        c.forward_mps = -share * most.most_back_mps;
        break;
      case Course::side:
        c.left_mps = side * share * most.most_side_mps;
        break;
      case Course::turn:
        c.turn_radps = side * share * most.most_turn_radps;
        break;
      case Course::mixed: {
        stretch = static_cast<int>(t_s / 4);
        math::Random random(trial.seed, 0x317ed, static_cast<std::uint64_t>(stretch));
        c.forward_mps = share * random.uniform(-most.most_back_mps, most.most_forward_mps);
        c.left_mps = share * random.uniform(-1, 1) * most.most_side_mps;
        c.turn_radps = share * random.uniform(-1, 1) * most.most_turn_radps;
        break;
      }
      case Course::stop_and_go:
        stretch = static_cast<int>(t_s / 3);
        c.walk = stretch % 2 == 0;
        if (c.walk) c.forward_mps = share * (stretch % 4 == 0 ? most.most_forward_mps : -most.most_back_mps);
        break;
    }
    return c;
  }
};

/// Where it looks, from the way that it goes, which is its heading without the sway of steps: 60 degrees to both sides
/// in turn, 20 degrees down.
double wanted_azimuth_rad(double t_s) { return kLookAside_rad * math::sin(2 * math::kPi * t_s / kLookPeriod_s); }
math::Vec3 direction(double azimuth_rad) {
  return math::Quat::from_axis_angle({0, 0, 1}, azimuth_rad)
      .rotate(math::Quat::from_axis_angle({0, 1, 0}, kLookDown_rad).rotate({1, 0, 0}));
}

motion::Planar planar(const kinematics::Pose& pose) { return {{pose.p_m.x, pose.p_m.y}, pose.q.yaw()}; }

}  // namespace

std::string to_string(Course course) {
  static constexpr const char* kNames[] = {"forward", "back", "side", "turn", "mixed", "stop_and_go"};
  return kNames[static_cast<std::size_t>(course)];
}

std::optional<WalkResult> run_walk(const GaitSetup& setup, const WalkTrial& trial, std::string& why) {
  const auto rig = Rig::create(setup, trial.seed, why);
  if (!rig) return std::nullopt;
  motion::Walk walk = rig->make_walk();
  motion::FallDetector fall(setup.book.fall);
  motion::Gaze gaze(rig->figure());
  gaze.params = setup.book.gaze;
  const kinematics::Place* camera = setup.body.find_place("camera");
  double looked = 0, way_rad = 0, look_rad = 0;
  walk.reset(rig->sense());
  const Commander commander{trial, setup.book.walk};
  math::Random random(trial.seed, 0x905);
  WalkResult out;
  motion::Planar begin_true, begin_odometry, last_true, last_odometry;
  double counted_s = 0, seconds = 0, changed_s = 0, next_push_s = trial.push_every_s * random.uniform(0.5, 1.5);
  double alarm_s = -1;
  int stretch = -1;
  motion::Vec2 before{};
  const auto ticks = static_cast<std::int64_t>((kStand_s + trial.lasts_s) / kControl_s + 0.5);
  const auto second = static_cast<std::int64_t>(1 / kControl_s + 0.5);
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    const double t_s = static_cast<double>(tick) * kControl_s - kStand_s;
    motion::WalkCommand command;
    int now_in = -1;
    if (t_s >= 0) command = commander.at(t_s, now_in);
    if (now_in != stretch) stretch = now_in, changed_s = t_s;
    if (trial.push_every_s > 0 && t_s > next_push_s) {
      next_push_s += trial.push_every_s * random.uniform(0.75, 1.25);
      const double to = rig->truth().torso.q.yaw() + trial.push.direction_rad;
      const double impulse_ns = trial.push.speed_mps * rig->figure().mass_kg();
      rig->pitch().push(0, {impulse_ns * math::cos(to), impulse_ns * math::sin(to), 0},
                        static_cast<std::int64_t>(trial.push.lasts_s * 1e9));
    }
    const motion::Sensed sensed = rig->sense();
    walk.step(command, sensed, kControl_s, rig->targets());
    if (trial.looks) {
      way_rad += math::wrap_pi(walk.odometry().yaw_rad - way_rad) * kControl_s / kWaySmooth_s;
      look_rad = way_rad + wanted_azimuth_rad(t_s);
      gaze.look_along(direction(look_rad));
      gaze.step({{}, walk.q_world_torso()}, walk.tilt.rate_radps(), sensed.joints_rad, kControl_s, rig->targets());
    }
    fall.step(walk.q_world_torso().conjugate().rotate({0, 0, 1}), walk.tilt.rate_radps(), kControl_s);
    rig->act(rig->targets());

    const plant::BodyTruth& truth = rig->truth();
    const motion::Planar at = planar(truth.torso), odometry = walk.odometry();
    if (tick == 0) begin_true = last_true = at, begin_odometry = last_odometry = odometry, before = at.at_m;
    if (trial.looks && camera && t_s >= 0) {
      // What the gyro's heading has drifted by is not the gaze's error.
      const math::Vec3 axis = (truth.link[camera->link] * camera->pose).q.rotate({1, 0, 0});
      const math::Vec3 wanted = direction(look_rad + at.yaw_rad - walk.odometry().yaw_rad);
      const double off_rad = math::atan2(norm(cross(axis, wanted)), dot(axis, wanted));
      out.off_axis_rad += off_rad;
      out.most_off_axis_rad = std::max(out.most_off_axis_rad, off_rad);
      looked += 1;
    }
    out.path_m += motion::norm(at.at_m - before);
    before = at.at_m;
    if (fall.way() != motion::FallWay::none && alarm_s < 0) alarm_s = t_s;  // also if it is taken back
    if (alarm_s >= 0 && t_s > alarm_s + 1) out.false_alarm = true, alarm_s = -1, fall.reset();
    out.tilt_rad = std::max({out.tilt_rad, math::fabs(fall.forward_rad()), math::fabs(fall.left_rad())});
    out.time_s = std::max(0.0, t_s + kControl_s);
    if (t_s >= 0 && t_s - changed_s > kSettled_s && command.walk) {
      const motion::Vec2 flat = motion::turned({truth.v_world_mps.x, truth.v_world_mps.y}, -at.yaw_rad);
      out.forward_mps += flat.x, out.left_mps += flat.y;
      out.turn_radps += truth.torso.q.rotate(truth.gyro_radps).z;
      out.wanted_forward_mps += command.forward_mps, out.wanted_left_mps += command.left_mps;
      out.wanted_turn_radps += command.turn_radps;
      counted_s += 1;
    }
    if (t_s > 0 && tick % second == 0) {
      const motion::Planar went = last_true.inverse() * at, thought = last_odometry.inverse() * odometry;
      out.step_error_m += motion::norm(went.at_m - thought.at_m);
      out.step_m += motion::norm(went.at_m);
      last_true = at, last_odometry = odometry;
      seconds += 1;
    }
    if (truth.fallen || truth.body_down) {
      out.fell = true;
      break;
    }
  }
  if (counted_s > 0)
    for (double* mean : {&out.forward_mps, &out.left_mps, &out.turn_radps, &out.wanted_forward_mps,
                         &out.wanted_left_mps, &out.wanted_turn_radps})
      *mean /= counted_s;
  if (looked > 0) out.off_axis_rad /= looked;
  if (seconds > 0) out.step_error_m /= seconds, out.step_m /= seconds;
  const motion::Planar went = begin_true.inverse() * planar(rig->truth().torso);
  const motion::Planar thought = begin_odometry.inverse() * walk.odometry();
  out.odometry_m = motion::norm(went.at_m - thought.at_m);
  out.steps = walk.steps();
  return out;
}

}  // namespace sinew::gait
