#include "robots/desk_head/world/head_world.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>

#include "math/random.hpp"
#include "robots/desk_head/world/desk_motion.hpp"
#include "robots/desk_head/world/follow_score.hpp"
#include "sim_hil/worlds/joint_servo.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/sensors.hpp"

namespace sinew::plant {
namespace {

using math::Quat;
using math::Vec3;

constexpr double kHeadStepS = 1e-9 * kStepNs;
constexpr double kYawRad = 0.1;  // of the platform, either way
constexpr double kBusVolt = 12;

ImuErrors head_imu_errors(bool on) {
  ImuErrors e{0, 0, 0, 0, 0, 0, 0, 0};
  if (on) e = {}, e.vibration_mps2 = 0;  // nothing shakes it
  return e;
}
JointErrors joint_errors(bool on) { return on ? JointErrors{} : JointErrors{0, 0, 0}; }

ServoParams servo_params(std::size_t joint) {
  ServoParams p;
  if (joint == 1) p.limits.least_rad = -1.0, p.limits.most_rad = 0.9;
  return p;
}

/// Where the pillar stands on the floor: left or right of the middle, where the ball passes often.
Vec3 pillar_place(bool stands, std::uint64_t seed) {
  math::Random random(seed, 0x70696c6c);
  const double side = random.below(2) == 0 ? 1 : -1, y = side * random.uniform(0.15, 0.40);
  return stands ? Vec3{0.95, y, 0} : Vec3{0, 0, -20};
}

Pose pose(const Vec3& p, const Quat& q) { return {p.to<msg::Vec3>(), q.to<msg::Quat>()}; }
Quat about_z(double rad) { return Quat::from_axis_angle({0, 0, 1}, rad); }
Quat about_y(double rad) { return Quat::from_axis_angle({0, 1, 0}, rad); }

}  // namespace

struct HeadWorld::Impl {
  explicit Impl(const HeadOptions& o)
      : options(o),
        rocking(o.rock_deg * (math::kPi / 180), o.rock_deg > 0 ? kYawRad : 0, o.seed),
        path(o.ball_speed, o.seed),
        pillar(pillar_place(o.pillar, o.seed)),
        imu(head_imu_errors(o.sensor_errors), o.seed),
        errors(joint_errors(o.sensor_errors)),
        noise(o.seed, 0x6a6f696e) {
    // The head starts in any direction, within the camera's limits.
    for (std::size_t i = 0; i < kHeadJoints; ++i) q[i] = 0.5 * noise.uniform(-1, 1);
    base = rocking.at(0);
    ball = path.at(0);
  }

  msg::Time now() const { return {steps * kStepNs}; }
  double now_s() const { return 1e-9 * static_cast<double>(steps * kStepNs); }
  Quat q_yoke() const { return base.q_world_base * about_z(q[0]); }
  Quat q_head() const { return q_yoke() * about_y(q[1]); }
  Vec3 p_yoke() const { return kPivot + base.q_world_base.rotate(kPBaseYoke); }
  Vec3 p_head() const { return p_yoke() + q_yoke().rotate(kPYokeHead); }
  CameraPose camera() const {
    const Quat head = q_head();
    return {(p_head() + head.rotate(kPHeadCamera)).to<msg::Vec3>(), (head * kQHeadOptical).to<msg::Quat>()};
  }
  bool hidden() const;
  void choose_drives(std::span<const double> command);
  void integrate();
  void sample();
  msg::JointState joint_state();

  HeadOptions options;
  Rocking rocking;
  BallPath path;
  Vec3 pillar;
  ImuModel imu;
  JointErrors errors;
  math::Random noise;
  std::array<JointServo, kHeadJoints> servo{JointServo(servo_params(0)), JointServo(servo_params(1))};
  std::array<double, kHeadJoints> q{}, v{}, effort{};
  std::array<JointDrive, kHeadJoints> acting;
  std::array<std::optional<JointDrive>, kHeadJoints> taken;  // by another drive command than the group's
  Rocking::State base;
  Vec3 ball;
  LinkMotion at_imu;
  Vec3 gyro_sum, accel_sum;  // since the last IMU sample
  std::int64_t steps = 0;
  std::uint32_t next_frame = 1;
  Due due;
  FollowScore score;
};

void HeadWorld::Impl::choose_drives(std::span<const double> command) {
  for (std::size_t i = 0; i < kHeadJoints; ++i) {
    acting[i] = {};
    if (taken[i])
      acting[i] = *taken[i];
    else if (i < command.size())
      acting[i].mode = DriveMode::position, acting[i].position_rad = command[i];
  }
}

void HeadWorld::Impl::integrate() {
  std::array<double, kHeadJoints> torque, armature;
  for (std::size_t i = 0; i < kHeadJoints; ++i) {
    effort[i] = servo[i].motor_nm(acting[i], q[i], v[i]);
    torque[i] = effort[i] + servo[i].friction_nm(q[i], v[i]);
    armature[i] = servo[i].params().armature_kgm2;
    servo[i].warm(effort[i], kHeadStepS);
  }
  const HeadMotion m = head_motion(base.motion, q, v, torque, armature);
  at_imu.w_radps = m.head.w_radps;
  at_imu.dw_radps2 = m.head.dw_radps2;
  at_imu.a_mps2 =
      m.head.a_mps2 + cross(m.head.dw_radps2, kPHeadImu) + cross(m.head.w_radps, cross(m.head.w_radps, kPHeadImu));
  gyro_sum += at_imu.w_radps + kHeadStepS * at_imu.dw_radps2;  // the rate with which the step moves the joints
  accel_sum += at_imu.a_mps2;
  for (std::size_t i = 0; i < kHeadJoints; ++i) {
    v[i] += kHeadStepS * m.accel_radps2[i];
    q[i] += kHeadStepS * v[i];
  }
  ++steps;
  base = rocking.at(now_s());
  ball = path.at(now_s());
}

/// The pillar is upright and taller than anything, so its plan view is enough.
bool HeadWorld::Impl::hidden() const {
  const Vec3 eye(camera().p_world_m), to = ball - eye;
  const double far = math::hypot(to.x, to.y);
  const double ux = to.x / far, uy = to.y / far, px = pillar.x - eye.x, py = pillar.y - eye.y;
  const double along = px * ux + py * uy, beside = math::fabs(px * uy - py * ux);
  return along > 0 && along < far && beside < kPillarRadius + kBallRadius * along / far;
}

msg::JointState HeadWorld::Impl::joint_state() {
  msg::JointState s;
  s.stamp = now();
  s.count = kHeadJoints;
  for (std::size_t i = 0; i < kHeadJoints; ++i) {
    s.measured[i] = now();
    s.position_rad[i] = encoder_rad(q[i], errors);
    s.velocity_radps[i] = v[i] + errors.rate_noise_radps * noise.normal();
    s.effort_nm[i] = effort[i] + errors.effort_noise_nm * noise.normal();
    s.temperature_c[i] = math::round(servo[i].temperature_c());
    s.voltage_v[i] = kBusVolt;
    const bool driven = acting[i].mode != DriveMode::off;
    s.mode[i] = driven ? msg::JointMode::enabled : msg::JointMode::disabled;
    s.ready |= (driven ? 1u : 0u) << i;
  }
  return s;
}

void HeadWorld::Impl::sample() {
  due.imu = steps % kImuSteps == 0;
  due.joints = steps % kJointSteps == 0;
  due.truth = steps % kTruthSteps == 0;
  due.cameras = now().ns == camera_stamp_ns(next_frame);
  if (due.cameras != 0) ++next_frame;
  if (due.imu) {
    constexpr double kShare = 1.0 / kImuSteps;
    due.imu_sample = imu.measure((kShare * gyro_sum).to<msg::Vec3>(), (kShare * accel_sum).to<msg::Vec3>(), 0,
                                 kImuSteps * kHeadStepS);
    due.imu_sample.stamp = {now().ns - kImuSteps * kStepNs / 2};  // the middle of the interval averaged over
    gyro_sum = accel_sum = {};
    score.look(now(), camera(), ball, base.q_world_base, hidden(), kImuSteps * kHeadStepS);
  }
  if (due.joints) due.joints_samples[0] = joint_state();
}

HeadWorld::HeadWorld(const HeadOptions& options) : impl_(std::make_unique<Impl>(options)) {}
HeadWorld::~HeadWorld() = default;

WorldInfo HeadWorld::info() { return {"desk_head", kHeadDevices, kHeadWorldOptions}; }

void HeadWorld::advance(std::span<const RobotCommand> commands) {
  impl_->choose_drives(commands[0]);
  impl_->integrate();
  impl_->sample();
}

const Due& HeadWorld::due() const { return impl_->due; }

msg::Time HeadWorld::now() const { return impl_->now(); }
Vec3 HeadWorld::ball_m() const { return impl_->ball; }
Quat HeadWorld::q_world_base() const { return impl_->base.q_world_base; }
Quat HeadWorld::q_world_head() const { return impl_->q_head(); }
CameraPose HeadWorld::camera_pose() const { return impl_->camera(); }
bool HeadWorld::ball_hidden() const { return impl_->hidden(); }
LinkMotion HeadWorld::imu_motion() const { return impl_->at_imu; }

WorldTruth HeadWorld::ground_truth() const {
  WorldTruth t;
  t.p_world_m = impl_->p_head().to<msg::Vec3>();
  t.q_world_base = impl_->q_head().to<msg::Quat>();
  t.gyro_radps = impl_->at_imu.w_radps.to<msg::Vec3>();
  t.target_world_m = impl_->ball.to<msg::Vec3>();
  t.battery_v = kBusVolt;
  return t;
}

/// In the order of the mocap bodies of robots/desk_head/world/room.xml.
Scene HeadWorld::scene(std::size_t /*camera*/) const {
  const Impl& w = *impl_;
  Scene s;
  s.camera = w.camera();
  s.bodies = 5;
  s.body = {pose(w.ball, {}), pose(w.pillar, {}), pose(kPivot, w.base.q_world_base), pose(w.p_yoke(), w.q_yoke()),
            pose(w.p_head(), w.q_head())};
  return s;
}

bool HeadWorld::still() const {
  constexpr double kStill_radps = 0.05;  // against the platform
  for (std::size_t i = 0; i < kHeadJoints; ++i)
    if (impl_->acting[i].mode != DriveMode::off || math::fabs(impl_->v[i]) > kStill_radps) return false;
  return true;
}

void HeadWorld::add_to(JsonObject& j) const {
  impl_->score.add_to(j);
  j.boolean("in_view", impl_->score.in_view());
  j.number("pan_rad", impl_->q[0]);
  j.number("tilt_rad", impl_->q[1]);
  j.boolean("at_rest", still());
  j.boolean("motors_stopped", impl_->acting[0].mode == DriveMode::off && impl_->acting[1].mode == DriveMode::off);
}

Verdict HeadWorld::verdict() const { return impl_->score.verdict(); }

std::string HeadWorld::outcome() const {
  const FollowScore& s = impl_->score;
  if (!s.acquired()) return "never had the ball in the middle of the picture";
  char text[160];
  std::snprintf(text, sizeof text, "ball in the picture %.1f %% of the time it could be, %.2f deg RMS off its middle",
                100 * s.in_view_share(), s.angle_rms_rad() * (180 / math::kPi));
  return text;
}

JointMotion HeadWorld::motion(std::size_t i) const {
  const Impl& w = *impl_;
  return {w.q[i], w.v[i], w.effort[i], w.servo[i].temperature_c(), w.acting[i]};
}
JointLimits HeadWorld::limits(std::size_t i) const { return impl_->servo[i].params().limits; }
void HeadWorld::drive(std::size_t i, const JointDrive& drive) { impl_->taken[i] = drive; }
void HeadWorld::release(std::size_t i) { impl_->taken[i].reset(); }

}  // namespace sinew::plant
