#include "robots/gripper/world/gripper_world.hpp"

#include <algorithm>

#include "math/random.hpp"
#include "sim_hil/pitch/painter.hpp"
#include "sim_hil/pitch/wheeled.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr std::int64_t kStepsOfPitch = kPitchStepNs / kStepNs;
constexpr std::uint32_t kBallStream = 0x62616c6c;
constexpr double kNearest_m = 1.3, kFarthest_m = 2.4, kAside_rad = 2 * math::kPi / 3;
constexpr double kFromEdge_m = 0.3;  // the ball lies on the field
constexpr double kBattery_v = 12;

/// Paddles of the pitch move in m, the gripper's motor in rad.
JointDrive of_paddle(JointDrive d) {
  d.position_rad *= kGripperLead_m_per_rad;
  d.velocity_radps *= kGripperLead_m_per_rad;
  d.effort_nm /= kGripperLead_m_per_rad;
  return d;
}

}  // namespace

WorldInfo GripperWorld::info() { return {"gripper", kGripperDevices, gripper_options()}; }

PitchOptions gripper_pitch(const WorldInfo& info, const WorldValues& values, std::uint64_t seed) {
  const auto value = [&](const char* key) { return info.value(values, key); };
  PitchOptions options;
  options.ground = GroundErrors::from(values);
  options.orange_ball = true;
  math::Random random(seed, kBallStream);
  const double drawn_m = random.uniform(kNearest_m, kFarthest_m), drawn_rad = random.uniform(-kAside_rad, kAside_rad);
  const double away_m = value("ball_away_m").value_or(drawn_m);
  const auto given_deg = value("ball_toward_deg");
  const double toward =
      value("start_heading_deg").value() * math::kPi / 180 + (given_deg ? *given_deg * math::kPi / 180 : drawn_rad);
  const double most_x = options.field.length_m / 2 - kFromEdge_m, most_y = options.field.width_m / 2 - kFromEdge_m;
  options.ball_at.x_m = std::clamp(value("start_x_m").value() + away_m * math::cos(toward), -most_x, most_x);
  options.ball_at.y_m = std::clamp(value("start_y_m").value() + away_m * math::sin(toward), -most_y, most_y);
  return options;
}

PitchBody gripper_body(const WorldInfo& info, const WorldValues& values) {
  PitchPlace start;
  start.x_m = info.value(values, "start_x_m").value_or(0);
  start.y_m = info.value(values, "start_y_m").value_or(0);
  start.heading_rad = info.value(values, "start_heading_deg").value() * math::kPi / 180;
  PitchBody body = pioneer_body(start);
  const BodyErrors own = body.errors;
  body.errors = BodyErrors::from(values);
  body.errors.backlash_deg = own.backlash_deg;
  body.errors.encoder_steps = own.encoder_steps;
  return body;
}

hal::Result<std::unique_ptr<GripperWorld>> GripperWorld::create(const WorldChoice& choice, std::uint64_t seed) {
  const WorldInfo& info = choice.type->info;
  const WorldValues values = choice.values_of(0);
  const PitchBody body = gripper_body(info, values);
  auto pitch = Pitch::create(gripper_pitch(info, values, seed), {&body, 1}, seed);
  if (!pitch) return pitch.error();
  return std::unique_ptr<GripperWorld>(new GripperWorld(std::move(*pitch), body.start));
}

GripperWorld::GripperWorld(std::unique_ptr<Pitch> pitch, const PitchPlace& start)
    : pitch_(std::move(pitch)), robot_(*pitch_, 0, {start.x_m, start.y_m, 0}) {}

void GripperWorld::advance(std::span<const RobotCommand> commands) {
  const bool moves = steps_ % kStepsOfPitch == kStepsOfPitch - 1;
  ++steps_;
  if (!moves) return robot_.nothing_due();
  robot_.act(commands[0], pitch_->now_ns());
  pitch_->step();
  robot_.sample(steps_);
}

GripperOnPitch::GripperOnPitch(Pitch& pitch, std::size_t number, const math::Vec3& goal_m)
    : pitch_(pitch), number_(number), score_(goal_m) {
  commanded_.fill(math::kNan);
}

// ---- commands

bool GripperOnPitch::drives(std::size_t joint) const {
  return taken_[joint] ? taken_[joint]->mode != DriveMode::off : math::is_finite(commanded_[joint]);
}

void GripperOnPitch::command(std::size_t joint, const JointDrive& drive) {
  if (joint != kGripperJoint) return pitch_.command(number_, joint == 0 ? kLeftWheel : kRightWheel, drive);
  for (const std::size_t paddle : {kLeftPaddle, kRightPaddle}) pitch_.command(number_, paddle, of_paddle(drive));
}

void GripperOnPitch::act(RobotCommand given, std::int64_t /*now_ns*/) {
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    const double value = joint < given.size() ? given[joint] : math::kNan;
    const bool same = value == commanded_[joint] || (math::is_nan(value) && math::is_nan(commanded_[joint]));
    if (same && !released_) continue;
    commanded_[joint] = value;
    if (taken_[joint]) continue;
    JointDrive drive;
    if (math::is_finite(value)) {
      drive.mode = joint == kGripperJoint ? DriveMode::position : DriveMode::velocity;
      (joint == kGripperJoint ? drive.position_rad : drive.velocity_radps) = value;
    }
    command(joint, drive);
  }
  released_ = false;
}

void GripperOnPitch::drive(std::size_t joint, const JointDrive& drive) {
  taken_[joint] = drive;
  command(joint, drive);
}

void GripperOnPitch::release(std::size_t joint) {
  taken_[joint].reset();
  released_ = true;
}

// ---- samples

JointMotion GripperOnPitch::motion(std::size_t joint) const {
  const BodyTruth& truth = pitch_.truth(number_);
  const BodySensors& said = pitch_.sensors(number_);
  JointMotion m;
  if (joint == kGripperJoint) {
    m.position_rad = (truth.joint_rad[kLeftPaddle] + truth.joint_rad[kRightPaddle]) / 2 / kGripperLead_m_per_rad;
    m.velocity_radps = (truth.joint_radps[kLeftPaddle] + truth.joint_radps[kRightPaddle]) / 2 / kGripperLead_m_per_rad;
    m.effort_nm = (said.joint[kLeftPaddle].effort_nm + said.joint[kRightPaddle].effort_nm) * kGripperLead_m_per_rad;
  } else {
    const std::size_t wheel = joint == 0 ? kLeftWheel : kRightWheel;
    m.position_rad = truth.joint_rad[wheel];
    m.velocity_radps = truth.joint_radps[wheel];
    m.effort_nm = said.joint[wheel].effort_nm;
  }
  if (taken_[joint]) {
    m.drive = *taken_[joint];
  } else if (math::is_finite(commanded_[joint])) {
    m.drive.mode = joint == kGripperJoint ? DriveMode::position : DriveMode::velocity;
    (joint == kGripperJoint ? m.drive.position_rad : m.drive.velocity_radps) = commanded_[joint];
  }
  return m;
}

JointLimits GripperOnPitch::limits(std::size_t joint) const {
  if (joint == kGripperJoint)
    return {0, kGripperMost_rad, kPioneer.grip_mps / kGripperLead_m_per_rad,
            2 * kPioneer.grip_n * kGripperLead_m_per_rad};
  return {-1e9, 1e9, kPioneer.fastest_mps / kPioneer.wheel_radius_m, kPioneer.wheel_stall_nm};
}

void GripperOnPitch::sample(std::int64_t steps) {
  const BodySensors& s = pitch_.sensors(number_);
  const auto every = [&](int n) { return steps % n == 0; };
  due_.imu = every(kGripperImuSteps), due_.joints = every(kGripperJointSteps), due_.truth = every(kTruthSteps);
  due_.cameras = every(kGripperCameraSteps) ? 1 : 0;
  due_.imu_sample = {{s.imu_stamp_ns}, s.gyro_radps.to<msg::Vec3>(), s.accel_mps2.to<msg::Vec3>()};
  const auto put = [&](msg::JointState& to, std::size_t i, const JointReading& reading, double scale,
                       std::size_t joint) {
    to.stamp = to.measured[i] = {s.joints_stamp_ns};
    to.position_rad[i] = reading.position_rad * scale;
    to.velocity_radps[i] = reading.velocity_radps * scale;
    to.effort_nm[i] = reading.effort_nm / scale;
    to.temperature_c[i] = reading.temperature_c;
    to.voltage_v[i] = kBattery_v;
    to.mode[i] = drives(joint) ? msg::JointMode::enabled : msg::JointMode::disabled;
    to.ready |= (drives(joint) ? 1u : 0u) << i;
  };
  if (due_.joints) {
    msg::JointState& wheels = due_.joints_samples[0] = {};
    wheels.count = 2;
    put(wheels, 0, s.joint[kLeftWheel], 1, 0);
    put(wheels, 1, s.joint[kRightWheel], 1, 1);
    JointReading both = s.joint[kLeftPaddle];
    const JointReading& right = s.joint[kRightPaddle];
    both.position_rad = (both.position_rad + right.position_rad) / 2;
    both.velocity_radps = (both.velocity_radps + right.velocity_radps) / 2;
    both.effort_nm += right.effort_nm;
    msg::JointState& gripper = due_.joints_samples[1] = {};
    gripper.count = 1;
    put(gripper, 0, both, 1 / kGripperLead_m_per_rad, kGripperJoint);
  }
  const bool driven = drives(0) || drives(1) || drives(2);
  score_.look(pitch_.truth(number_), pitch_.ball(), driven);
}

void GripperOnPitch::nothing_due() {
  due_.imu = due_.joints = due_.truth = false;
  due_.cameras = 0;
}

// ---- what is so

WorldTruth GripperOnPitch::ground_truth() const {
  const BodyTruth& truth = pitch_.truth(number_);
  WorldTruth t;
  t.p_world_m = truth.torso.p_m.to<msg::Vec3>();
  t.v_world_mps = truth.v_world_mps.to<msg::Vec3>();
  t.q_world_base = truth.torso.q.to<msg::Quat>();
  t.gyro_radps = truth.gyro_radps.to<msg::Vec3>();
  t.target_world_m = pitch_.ball().p_m.to<msg::Vec3>();
  t.battery_v = kBattery_v;
  t.landed = true;
  return t;
}

Scene GripperOnPitch::scene(std::size_t camera) const { return pitch_scene(pitch_, number_, camera); }

bool GripperOnPitch::still() const {
  const BodyTruth& truth = pitch_.truth(number_);
  const bool driven = drives(0) || drives(1) || drives(2);
  return !driven && math::norm(truth.v_world_mps) < 0.02 && math::norm(truth.gyro_radps) < 0.1;
}

void GripperOnPitch::add_to(JsonObject& report) const {
  const BodyTruth& truth = pitch_.truth(number_);
  score_.add_to(report);
  report.number("x_m", truth.torso.p_m.x);
  report.number("y_m", truth.torso.p_m.y);
  report.number("heading_deg", truth.torso.q.yaw() * 180 / math::kPi);
  report.number("ball_x_m", pitch_.ball().p_m.x);
  report.number("ball_y_m", pitch_.ball().p_m.y);
  report.integer("physics_warnings", pitch_.trouble());
  report.boolean("at_rest", still());
  report.boolean("motors_stopped", !(drives(0) || drives(1) || drives(2)));
}

}  // namespace sinew::plant
