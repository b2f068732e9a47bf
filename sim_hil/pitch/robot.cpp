#include "sim_hil/pitch/robot.hpp"

#include <algorithm>

namespace sinew::plant {
namespace {

ModelRobot true_body(const PitchBody& given, const RobotDraw& draw) {
  ModelRobot out{given.body, draw.sole_friction, given.kind};
  for (std::size_t i = 0; i < out.body.links.size(); ++i) {
    kinematics::Link& link = out.body.links[i];
    link.mass_kg *= draw.mass[i];
    for (double& value : link.inertia_kgm2) value *= draw.mass[i];
  }
  // A sole is tilted about the middle of its underside; the place of the drawing's name goes with it.
  const auto soles = soles_of(given.body);
  for (std::size_t side = 0; side < 2; ++side) {
    if (!soles[side]) continue;
    const Sole& sole = *soles[side];
    const kinematics::Pose under = sole.box * kinematics::Pose{{0, 0, -sole.half_m.z}, {}};
    const kinematics::Pose moved = under * draw.sole[side] * under.inverse();
    kinematics::Shape& shape = out.body.links[sole.link].shapes[sole.shape];
    const kinematics::Pose box = moved * kinematics::Pose{shape.at_m, shape.q};
    shape.at_m = box.p_m, shape.q = box.q;
    for (kinematics::Place& place : out.body.places)
      if (place.name == (side == 0 ? "l_sole" : "r_sole")) place.pose = moved * place.pose;
  }
  return out;
}

GearedServo servo_of(const PitchBody& given, const RobotDraw& draw, std::size_t joint) {
  const kinematics::Link& link = given.body.links[joint + 1];
  const BodyErrors& e = given.errors;
  GearedServoParams p;
  if (link.servo < given.body.servos.size()) {
    const kinematics::ServoType& type = given.body.servos[link.servo];
    p.stall_nm = type.stall_nm, p.no_load_radps = type.no_load_radps, p.armature_kgm2 = type.armature_kgm2;
  }
  if (math::is_finite(e.stall_nm)) p.stall_nm = e.stall_nm;
  if (math::is_finite(e.no_load_radps)) p.no_load_radps = e.no_load_radps;
  p.gain_per_rad = given.gain_per_rad * draw.gain[joint];
  p.play_rad = e.backlash_deg * math::kPi / 180;
  p.friction_nm = e.gear_friction_share * p.stall_nm;
  p.encoder_step_rad = e.encoder_steps > 0 ? 2 * math::kPi / e.encoder_steps : 0;
  p.encoder_at_motor = e.encoder_at_motor != 0;
  p.ambient_c = e.ambient_c;
  return GearedServo(p);
}

}  // namespace

std::vector<PitchRobot> robots_of(std::span<const PitchBody> bodies, std::uint64_t seed) {
  std::vector<PitchRobot> robots;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const PitchBody& given = bodies[i];
    const RobotDraw draw(given.errors, seed, i);
    const std::size_t joints = given.body.joints();
    PitchRobot r{true_body(given, draw), given.errors, draw, RobotIo(given.errors, draw, joints, seed, i), {}};
    r.soles = soles_of(r.model.body);
    for (std::size_t j = 0; j < joints; ++j) r.servo.push_back(servo_of(given, draw, j));
    r.limit.assign(joints, 1);
    robots.push_back(std::move(r));
  }
  return robots;
}

void PitchOfRobots::command(std::size_t robot, std::span<const double> targets_rad) {
  RobotIo& io = robot_[robot].io;
  for (std::size_t j = 0; j < std::min(targets_rad.size(), io.joints()); ++j)
    io.said(j) = math::is_nan(targets_rad[j]) ? JointDrive{} : JointDrive{DriveMode::position, targets_rad[j]};
}

void PitchOfRobots::command(std::size_t robot, std::size_t joint, const JointDrive& drive) {
  if (joint < robot_[robot].io.joints()) robot_[robot].io.said(joint) = drive;
}

void PitchOfRobots::limit(std::size_t robot, std::size_t joint, double share) {
  if (joint < robot_[robot].limit.size()) robot_[robot].limit[joint] = share >= 0 ? std::min(share, 1.0) : 0;
}

void PitchOfRobots::gain(std::size_t robot, std::size_t joint, double gain_per_rad) {
  PitchRobot& r = robot_[robot];
  if (joint < r.servo.size()) r.servo[joint].set_gain(gain_per_rad * r.draw.gain[joint]);
}

void PitchOfRobots::push(std::size_t robot, const math::Vec3& impulse_ns, std::int64_t duration_ns) {
  const std::int64_t steps = std::max<std::int64_t>(1, (duration_ns + kPitchStepNs / 2) / kPitchStepNs);
  robot_[robot].push_n = impulse_ns / (static_cast<double>(steps) * kPitchStepNs * 1e-9);
  robot_[robot].push_end_ns = now_ns_ + steps * kPitchStepNs;
}

}  // namespace sinew::plant
