// The pitch without dynamics.
//
// Source: the scheme of the RoboFrame simulator: at least one foot is on the ground, the lowest one, and does not slip.
#include "sim_hil/pitch/kinematic.hpp"

#include <algorithm>

#include "sim_hil/pitch/robot.hpp"
#include "sim_hil/pitch/wheeled.hpp"

namespace sinew::plant {
namespace {

using kinematics::BodyPose;
using kinematics::Pose;
using math::Quat;
using math::Vec3;

constexpr double kDt_s = kPitchStepNs * 1e-9;
constexpr double kOtherFootLower_m = 0.001;  // from here on the other foot is the one that stands
constexpr double kBothFeet_m = 0.002;        // feet that differ by less share the weight
constexpr double kBallBounce = 0.5;          // of the speed, off posts and feet
constexpr double kEarth_mps2 = 9.81;
constexpr double kFollows_s = 0.05;    // the torso that the IMU feels, ours
constexpr double kLaysFlat_radps = 1;  // a foot that comes down askew: at once would be a blow to the gyro

/// Turned towards flat by at most so much; on the ground.
Pose laid_flatter(const Pose& p, double most_rad) {
  const Vec3 up = p.q.rotate({0, 0, 1}), axis = cross(up, Vec3{0, 0, 1});
  const double sine = norm(axis), tilt = math::atan2(sine, up.z);
  const Pose down{{p.p_m.x, p.p_m.y, 0}, p.q};
  if (sine < 1e-12) return down;
  return {down.p_m, (Quat::from_axis_angle(axis / sine, std::min(tilt, most_rad)) * p.q).normalized()};
}

/// Flat on the ground: only place and heading are left.
Pose flattened(const Pose& p) { return {{p.p_m.x, p.p_m.y, 0}, Quat::from_axis_angle({0, 0, 1}, p.q.yaw())}; }

struct Mover {
  std::vector<double> rad{}, radps{};
  std::size_t foot = 0;  // the one that stands
  Pose held;             // its sole in the world; of a robot without soles or that lies: link 0
  bool stands = false;
  Quat felt_q{};      // of the torso, as the IMU feels it
  bool fresh = true;  // nothing to take differences with
};

class KinematicPitch final : public PitchOfRobots {
 public:
  KinematicPitch(const PitchOptions& options, std::vector<PitchRobot> robots, std::span<const PitchBody> bodies)
      : PitchOfRobots(options, std::move(robots)), mover_(robot_.size()) {
    for (const PitchRobot& r : robot_) pose_.emplace_back(r.model.body);
    for (std::size_t i = 0; i < robot_.size(); ++i) place(i, bodies[i].start);
    place_ball({o_.ball_at.x_m, o_.ball_at.y_m, 0}, {});
    for (PitchRobot& r : robot_) r.io.measure(r.measured, now_ns_);
  }

  std::uint64_t trouble() const override { return 0; }
  void place(std::size_t robot, const PitchPlace& at) override;
  void place_ball(const Vec3& p_m, const Vec3& v_mps) override {
    ball_.touched_by = -1;
    ball_.p_m = {p_m.x, p_m.y, o_.ball.radius_m};
    ball_.v_mps = {v_mps.x, v_mps.y, 0};
  }
  void step() override;

 private:
  void turn_joints(std::size_t robot);
  void stand(std::size_t robot);
  void roll_wheels(std::size_t robot);
  void tell(std::size_t robot);
  void move_ball();
  void touch_ball(std::size_t robot);
  void bounce(const Vec3& normal, double deep_m, const Vec3& v_mps, double share = kBallBounce);
  Pose sole(std::size_t robot, std::size_t side) const {
    const Sole& s = *robot_[robot].soles[side];
    return pose_[robot].link(s.link) * s.box * Pose{{0, 0, -s.half_m.z}, {}};
  }

  std::vector<Mover> mover_;
  std::vector<BodyPose> pose_;
};

void KinematicPitch::place(std::size_t robot, const PitchPlace& at) {
  PitchRobot& r = robot_[robot];
  Mover& m = mover_[robot];
  m.rad.assign(r.io.joints(), 0);
  m.radps.assign(r.io.joints(), 0);
  std::copy_n(at.joints_rad.begin(), std::min(at.joints_rad.size(), m.rad.size()), m.rad.begin());
  const Pose base = pose_on_ground(r.model.body, at, 0);
  pose_[robot].set(m.rad, base);
  m.stands = at.lie == PitchPlace::Lie::upright && r.soles[0] && r.soles[1];
  m.foot = m.stands && sole(robot, 1).p_m.z < sole(robot, 0).p_m.z ? 1 : 0;
  m.held = m.stands ? flattened(sole(robot, m.foot)) : base;
  m.fresh = true;
  if (m.stands) stand(robot);
  tell(robot);
}

/// As fast as the motors can; joints without torque stay as they are.
void KinematicPitch::turn_joints(std::size_t robot) {
  PitchRobot& r = robot_[robot];
  Mover& m = mover_[robot];
  const std::span<const JointDrive> drives = r.io.obeyed();
  for (std::size_t j = 0; j < drives.size(); ++j) {
    const kinematics::Link& link = r.model.body.links[j + 1];
    const double most = r.servo[j].params().no_load_radps * r.limit[j];
    double speed = 0;
    if (drives[j].mode == DriveMode::position || drives[j].mode == DriveMode::impedance)
      speed = (drives[j].position_rad - m.rad[j]) / kDt_s;
    else if (drives[j].mode == DriveMode::velocity)
      speed = drives[j].velocity_radps;
    speed = math::is_nan(speed) ? 0 : std::clamp(speed, -most, most);
    const double to = std::clamp(m.rad[j] + speed * kDt_s, link.least_rad, link.most_rad);
    m.radps[j] = (to - m.rad[j]) / kDt_s;
    m.rad[j] = to;
  }
}

/// The standing foot stays where it is and comes to lie flat; where the other one would be below it, that one stands.
void KinematicPitch::stand(std::size_t robot) {
  Mover& m = mover_[robot];
  const auto over = [&](std::size_t side, const Pose& held) {
    pose_[robot].set(m.rad);
    pose_[robot].set(m.rad, held * sole(robot, side).inverse());
  };
  m.held = laid_flatter(m.held, kLaysFlat_radps * kDt_s);
  over(m.foot, m.held);
  const Pose other = sole(robot, 1 - m.foot);
  if (other.p_m.z < -kOtherFootLower_m) {
    m.foot = 1 - m.foot;
    m.held = laid_flatter(other, 0);
    over(m.foot, m.held);
  }
}

void KinematicPitch::roll_wheels(std::size_t robot) {
  Mover& m = mover_[robot];
  const double left = m.radps[kLeftWheel] * kPioneer.wheel_radius_m;
  const double right = m.radps[kRightWheel] * kPioneer.wheel_radius_m;
  const double turn = (right - left) / kPioneer.track_m * kDt_s, way = (left + right) / 2 * kDt_s;
  const Quat half = Quat::from_axis_angle({0, 0, 1}, turn / 2);
  m.held.p_m += (m.held.q * half).rotate({way, 0, 0});
  m.held.q = (m.held.q * half * half).normalized();
  // Of its links only the wheels turn; tell() moves the paddles, which slide.
  pose_[robot].set({m.rad.data(), kLeftPaddle}, m.held);
}

/// Truth and measurements.
void KinematicPitch::tell(std::size_t robot) {
  PitchRobot& r = robot_[robot];
  Mover& m = mover_[robot];
  BodyTruth& t = r.truth;
  const Pose before = t.torso;
  for (std::size_t l = 0; l < r.model.body.links.size(); ++l) t.link[l] = pose_[robot].link(l);
  if (r.model.kind == PitchBody::Kind::wheeled)
    for (const std::size_t j : {kLeftPaddle, kRightPaddle})
      t.link[j + 1].p_m += t.link[0].q.rotate(r.model.body.links[j + 1].axis * m.rad[j]);
  t.torso = t.link[0];
  t.v_world_mps = m.fresh ? Vec3{} : (t.torso.p_m - before.p_m) / kDt_s;
  t.gyro_radps = m.fresh ? Vec3{} : (before.q.conjugate() * t.torso.q).log() / kDt_s;
  const double up = t.torso.q.rotate({0, 0, 1}).z;
  t.tilt_rad = math::acos(std::clamp(up, -1.0, 1.0));
  t.fallen = up < 0.5;
  t.body_down = !m.stands && r.model.kind == PitchBody::Kind::legged;
  for (std::size_t j = 0; j < m.rad.size(); ++j) {
    t.joint_rad[j] = m.rad[j], t.joint_radps[j] = m.radps[j];
    r.measured.joint[j] = {r.servo[j].encoder_rad(m.rad[j]), m.radps[j], 0, r.servo[j].temperature_c()};
  }
  // The weight is where the centre of mass is.
  t.foot_n = {};
  r.measured.cell_n = {};
  if (m.stands) {
    const double weight_n = kEarth_mps2 * r.model.body.mass_kg();
    const Vec3 com = pose_[robot].centre_of_mass();
    const Pose mine = sole(robot, m.foot), other = sole(robot, 1 - m.foot);
    const bool both = other.p_m.z < kBothFeet_m;
    const Vec3 way = other.p_m - mine.p_m;
    const double share = both ? std::clamp(dot(com - mine.p_m, way) / squared_norm(way), 0.0, 1.0) : 0;
    t.foot_n[m.foot] = weight_n * (1 - share);
    t.foot_n[1 - m.foot] = weight_n * share;
    for (std::size_t side = 0; side < 2; ++side) {
      const Vec3 at = sole(robot, side).inverse().of({com.x, com.y, 0});
      const auto shares = cell_shares(*r.soles[side], at);
      for (std::size_t k = 0; k < 4; ++k) r.measured.cell_n[side][k] = t.foot_n[side] * shares[k];
    }
  }
  // The IMU of a robot that stands feels an upright torso that turns, since nothing here can fall: a walk answers a
  // tilt with its ankles, which turn the torso at once where no mass has to follow, and the loop would swing itself up.
  const Quat felt = m.stands ? Quat::from_axis_angle({0, 0, 1}, t.torso.q.yaw()) : t.torso.q;
  if (m.fresh) m.felt_q = felt;
  const Vec3 turn = (m.felt_q.conjugate() * felt).log();
  m.felt_q = (m.felt_q * Quat::exp(turn * (kDt_s / kFollows_s))).normalized();
  const kinematics::Place* const place = r.model.body.find_place("imu");
  const Quat q_torso_imu = place ? t.torso.q.conjugate() * (t.link[place->link] * place->pose).q : Quat{};
  r.measured.gyro_radps = q_torso_imu.conjugate().rotate(turn / kFollows_s);
  r.measured.accel_mps2 = (m.felt_q * q_torso_imu).conjugate().rotate({0, 0, kEarth_mps2});
  m.fresh = false;
}

/// Something solid is `deep_m` inside the ball, and moves with this speed.
void KinematicPitch::bounce(const Vec3& normal, double deep_m, const Vec3& v_mps, double share) {
  ball_.p_m += normal * deep_m;
  const double apart = dot(ball_.v_mps - v_mps, normal);
  if (apart < 0) ball_.v_mps += normal * (-(1 + share) * apart);
}

void KinematicPitch::touch_ball(std::size_t robot) {
  const PitchRobot& r = robot_[robot];
  const auto& links = r.model.body.links;
  if (math::hypot(r.truth.torso.p_m.x - ball_.p_m.x, r.truth.torso.p_m.y - ball_.p_m.y) > 1) return;
  for (std::size_t l = 0; l < links.size(); ++l)
    for (const kinematics::Shape& s : links[l].shapes) {
      if (!s.contact || s.kind == kinematics::Shape::Kind::sphere) continue;
      const Pose at = r.truth.link[l] * Pose{s.at_m, s.q};
      const Vec3 half = s.kind == kinematics::Shape::Kind::box
                            ? s.size_m * 0.5
                            : Vec3{s.size_m.x, s.size_m.x, s.size_m.x + s.size_m.z / 2};
      const Vec3 inside = at.inverse().of(ball_.p_m);
      const Vec3 nearest{std::clamp(inside.x, -half.x, half.x), std::clamp(inside.y, -half.y, half.y),
                         std::clamp(inside.z, -half.z, half.z)};
      Vec3 way = ball_.p_m - at.of(nearest);
      const double far = norm(way);
      if (far >= o_.ball.radius_m) continue;
      way.z = 0;
      if (norm(way) < 1e-6) way = ball_.p_m - r.truth.torso.p_m, way.z = 0;
      const Vec3 normal = math::normalized(way);
      const Vec3 arm = at.of(nearest) - r.truth.torso.p_m;
      Vec3 v = r.truth.v_world_mps + cross(r.truth.torso.q.rotate(r.truth.gyro_radps), arm);
      for (std::size_t j = l; j != 0; j = links[j].parent) {
        if (r.model.kind == PitchBody::Kind::wheeled) {
          if (l > kRightWheel + 1) v += r.truth.link[0].q.rotate(links[l].axis * r.truth.joint_radps[l - 1]);
          break;
        }
        v += cross(r.truth.link[j].q.rotate(links[j].axis * r.truth.joint_radps[j - 1]),
                   at.of(nearest) - r.truth.link[j].p_m);
      }
      v.z = 0;
      bounce(normal, o_.ball.radius_m - far, v);
      ball_.touched_by = static_cast<int>(robot);
    }
}

void KinematicPitch::move_ball() {
  if (!o_.has_ball) return;
  const double speed = norm(ball_.v_mps);
  if (speed > 0) ball_.v_mps *= std::max(0.0, 1 - o_.ground.ball_deceleration_mps2 * kDt_s / speed);
  ball_.p_m += ball_.v_mps * kDt_s;
  for (std::size_t i = 0; i < robot_.size(); ++i) touch_ball(i);
  const FieldSize& f = o_.field;
  const double half = f.goal_width_m / 2 + f.post_radius_m, reach = f.post_radius_m + o_.ball.radius_m;
  for (const double x : {-f.length_m / 2, f.length_m / 2}) {
    for (const double y : {-half, half}) {
      const Vec3 way{ball_.p_m.x - x, ball_.p_m.y - y, 0};
      const double far = norm(way);
      if (far < reach && far > 0) bounce(way / far, reach - far, {});
    }
    // The net: from inside of the goal the ball does not get out at the back and the sides.
    const double outwards = x > 0 ? 1 : -1, deep = (ball_.p_m.x - x) * outwards;
    if (deep > 0 && deep < f.goal_depth_m && math::fabs(ball_.p_m.y) < half) {
      const double past = deep + o_.ball.radius_m - f.goal_depth_m;
      if (past > 0) bounce({-outwards, 0, 0}, past, {}, 0);
      const double aside = math::fabs(ball_.p_m.y) + o_.ball.radius_m - half;
      if (aside > 0) bounce({0, ball_.p_m.y > 0 ? -1.0 : 1.0, 0}, aside, {}, 0);
    }
  }
  ball_.p_m.z = o_.ball.radius_m;
  ball_.spin_radps = {-ball_.v_mps.y / o_.ball.radius_m, ball_.v_mps.x / o_.ball.radius_m, 0};
  ball_.q = (Quat::exp(ball_.spin_radps * kDt_s) * ball_.q).normalized();
}

void KinematicPitch::step() {
  now_ns_ += kPitchStepNs;
  for (std::size_t i = 0; i < robot_.size(); ++i) {
    turn_joints(i);
    if (robot_[i].model.kind == PitchBody::Kind::wheeled)
      roll_wheels(i);
    else if (mover_[i].stands)
      stand(i);
    else
      pose_[i].set(mover_[i].rad, mover_[i].held);
    tell(i);
    robot_[i].io.measure(robot_[i].measured, now_ns_);
  }
  move_ball();
}

}  // namespace

std::unique_ptr<Pitch> create_kinematic_pitch(const PitchOptions& options, std::span<const PitchBody> bodies,
                                              std::uint64_t seed) {
  return std::make_unique<KinematicPitch>(options, robots_of(bodies, seed), bodies);
}

}  // namespace sinew::plant
