// The pitch on MuJoCo's own dynamics.
#include "sim_hil/pitch/dynamic.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>

#include "sim_hil/mujoco/room.hpp"
#include "sim_hil/pitch/ground.hpp"
#include "sim_hil/pitch/model.hpp"
#include "sim_hil/pitch/robot.hpp"

namespace sinew::plant {
namespace {

using math::Quat;
using math::Vec3;

constexpr double kStep_s = kPitchStepNs * 1e-9;
constexpr double kAbove_m = 0.002;              // of a robot that is put somewhere
constexpr double kBallOnGround_m = 0.003;       // lower than this over the ground, a ball rolls
constexpr double kFallenCosine = 0.5;           // of 60 degrees
constexpr double kSpeedStep_radps = 0.0239808;  // 0.229 turns a minute: the unit of X-series servos
constexpr double kGravity_mps2 = 9.81;
constexpr std::uint32_t kGroundStream = 0x70697467;

Vec3 vec_of(const mjtNum* v) { return {v[0], v[1], v[2]}; }
Quat quat_of(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }
std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Where a robot is in the model.
struct InModel {
  std::vector<int> link_body{}, joint_qpos{}, joint_dof{};
  int base_qpos = 0, base_dof = 0, imu_site = -1;
  std::array<int, 2> sole_geom{-1, -1};
  Vec3 imu_mps{};  // in the step before
};

class DynamicPitch final : public PitchOfRobots {
 public:
  DynamicPitch(const PitchOptions& options, std::vector<PitchRobot> robots, ModelPtr model, std::uint64_t seed)
      : PitchOfRobots(options, std::move(robots)),
        at_(robot_.size()),
        model_(std::move(model)),
        data_(mj_makeData(model_.get())) {
    find_all();
    raise_ground(seed);
  }

  std::uint64_t trouble() const override {
    std::uint64_t sum = 0;
    for (const mjWarningStat& w : data_->warning) sum += static_cast<std::uint64_t>(w.number);
    return sum;
  }

  void place_ball(const Vec3& p_m, const Vec3& v_mps) override;
  void place(std::size_t robot, const PitchPlace& at) override;
  void step() override;
  /// Once.
  void start(std::span<const PitchBody> bodies) {
    for (std::size_t i = 0; i < robot_.size(); ++i) put(i, bodies[i].start);
    place_ball({o_.ball_at.x_m, o_.ball_at.y_m, 0}, {});
    mj_step1(model_.get(), data_.get());
    for (std::size_t i = 0; i < robot_.size(); ++i) {
      look_at(i, true);
      robot_[i].io.measure(robot_[i].measured, now_ns_);
    }
    look_at_ball();
  }

 private:
  int id(int type, const std::string& name) const { return mj_name2id(model_.get(), type, name.c_str()); }
  void find_all();
  void raise_ground(std::uint64_t seed);
  void drive(std::size_t robot);
  void brake_ball();
  void feel_contacts();
  void look_at(std::size_t robot, bool first);
  void look_at_ball();
  void put(std::size_t robot, const PitchPlace& at);

  std::vector<InModel> at_;
  ModelPtr model_;
  DataPtr data_;
  int ball_body_ = -1, ball_qpos_ = 0, ball_dof_ = 0;
  std::vector<int> robot_of_body_{}, sole_of_geom_{};  // -1: none; a sole: 0 left, 1 right
};

void DynamicPitch::find_all() {
  robot_of_body_.assign(index(model_->nbody), -1);
  sole_of_geom_.assign(index(model_->ngeom), -1);
  for (std::size_t i = 0; i < robot_.size(); ++i) {
    const PitchRobot& r = robot_[i];
    InModel& at = at_[i];
    const std::string end = robot_name_end(i);
    const kinematics::Body& body = r.model.body;
    for (std::size_t l = 0; l < body.links.size(); ++l) {
      const int mine = id(mjOBJ_BODY, body.links[l].name + end), joint = id(mjOBJ_JOINT, body.links[l].name + end);
      at.link_body.push_back(mine);
      robot_of_body_[index(mine)] = static_cast<int>(i);
      // Its shapes touch uneven ground, too.
      for (int g = 0; g < model_->body_geomnum[mine]; ++g)
        model_->geom_conaffinity[model_->body_geomadr[mine] + g] |= kUneven;
      if (l == 0) {
        at.base_qpos = model_->jnt_qposadr[joint], at.base_dof = model_->jnt_dofadr[joint];
      } else {
        at.joint_qpos.push_back(model_->jnt_qposadr[joint]);
        at.joint_dof.push_back(model_->jnt_dofadr[joint]);
      }
    }
    if (body.find_place("imu")) at.imu_site = id(mjOBJ_SITE, "imu" + end);
    for (std::size_t side = 0; side < 2; ++side) {
      if (!r.soles[side]) continue;
      const auto& shapes = body.links[r.soles[side]->link].shapes;
      int geom = model_->body_geomadr[at.link_body[r.soles[side]->link]];
      for (std::size_t s = 0; s < r.soles[side]->shape; ++s) geom += shapes[s].contact ? 1 : 0;
      at.sole_geom[side] = geom;
      sole_of_geom_[index(geom)] = static_cast<int>(side);
    }
  }
  ball_body_ = id(mjOBJ_BODY, kBallName);
  if (ball_body_ >= 0) {
    const int joint = model_->body_jntadr[ball_body_];
    ball_qpos_ = model_->jnt_qposadr[joint], ball_dof_ = model_->jnt_dofadr[joint];
  }
}

void DynamicPitch::raise_ground(std::uint64_t seed) {
  const int field = id(mjOBJ_HFIELD, kGroundName);
  if (field < 0) return;
  math::Random random(seed, kGroundStream);
  float* const heights = model_->hfield_data + model_->hfield_adr[field];
  const int points = model_->hfield_nrow[field] * model_->hfield_ncol[field];
  for (int i = 0; i < points; ++i) heights[i] = static_cast<float>(random.uniform());
}

void DynamicPitch::put(std::size_t robot, const PitchPlace& place) {
  PitchRobot& r = robot_[robot];
  const InModel& at = at_[robot];
  const kinematics::Pose base = pose_on_ground(r.model.body, place, kAbove_m + o_.ground.roughness_mm / 1000);
  const double start[7] = {base.p_m.x, base.p_m.y, base.p_m.z, base.q.w, base.q.x, base.q.y, base.q.z};
  std::copy_n(start, 7, data_->qpos + at.base_qpos);
  std::fill_n(data_->qvel + at.base_dof, 6, 0.0);
  std::fill_n(data_->qacc + at.base_dof, 6, 0.0);
  std::fill_n(data_->qacc_warmstart + at.base_dof, 6, 0.0);
  for (std::size_t j = 0; j < at.joint_qpos.size(); ++j) {
    data_->qpos[at.joint_qpos[j]] = j < place.joints_rad.size() ? place.joints_rad[j] : 0;
    data_->qvel[at.joint_dof[j]] = data_->qacc[at.joint_dof[j]] = data_->qacc_warmstart[at.joint_dof[j]] = 0;
  }
  r.push_end_ns = now_ns_;
}

void DynamicPitch::place(std::size_t robot, const PitchPlace& at) {
  put(robot, at);
  mj_step1(model_.get(), data_.get());
  look_at(robot, true);
}

void DynamicPitch::place_ball(const Vec3& p, const Vec3& v) {
  if (ball_body_ < 0) return;
  ball_.touched_by = -1;
  const double at[7] = {p.x, p.y, std::max(p.z, o_.ball.radius_m), 1, 0, 0, 0};
  const double moves[6] = {v.x, v.y, v.z, -v.y / o_.ball.radius_m, v.x / o_.ball.radius_m, 0};  // it rolls
  std::copy_n(at, 7, data_->qpos + ball_qpos_);
  std::copy_n(moves, 6, data_->qvel + ball_dof_);
  std::fill_n(data_->qacc_warmstart + ball_dof_, 6, 0.0);
  mj_step1(model_.get(), data_.get());
  look_at_ball();
}

/// Torques of the servos, and the damping that belongs to them.
void DynamicPitch::drive(std::size_t robot) {
  PitchRobot& r = robot_[robot];
  const InModel& at = at_[robot];
  const std::span<const JointDrive> drives = r.io.obeyed();
  for (std::size_t j = 0; j < drives.size(); ++j) {
    const int dof = at.joint_dof[j];
    const double v = data_->qvel[dof];
    const ServoTorque torque =
        r.servo[j].step(drives[j], r.limit[j], data_->qpos[at.joint_qpos[j]], v, data_->qacc[dof], kStep_s);
    // The passive force of this step was computed with the damping of the one before.
    data_->qfrc_applied[dof] = torque.effort_nm + (model_->dof_damping[dof] - torque.damping_nms) * v;
    model_->dof_damping[dof] = torque.damping_nms;
  }
  mjtNum* const torso = data_->xfrc_applied + 6 * at.link_body[0];
  const Vec3 push = now_ns_ < r.push_end_ns ? r.push_n : Vec3{};
  torso[0] = push.x, torso[1] = push.y, torso[2] = push.z;
}

/// Grass takes a rolling ball's speed evenly. A torque against its spin, since friction holds its lowest point.
void DynamicPitch::brake_ball() {
  if (ball_body_ < 0) return;
  mjtNum* const wrench = data_->xfrc_applied + 6 * ball_body_;
  const double r = o_.ball.radius_m, m = o_.ball.mass_kg, inertia = 2.0 / 3 * m * r * r + m * r * r;
  const double spin = norm(ball_.spin_radps);
  double torque_nm = 0;
  if (ball_.p_m.z < r + kBallOnGround_m && spin > 0)
    torque_nm = std::min(o_.ground.ball_deceleration_mps2 * inertia / r, inertia * spin / kStep_s) / spin;
  for (int i = 0; i < 3; ++i) wrench[3 + i] = -torque_nm * ball_.spin_radps[i];
}

void DynamicPitch::feel_contacts() {
  for (PitchRobot& r : robot_) {
    r.measured.cell_n = {};
    r.truth.foot_n = {};
    r.truth.body_down = false;
  }
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& c = data_->contact[i];
    for (const int geom : {c.geom1, c.geom2}) {
      const int robot = robot_of_body_[index(model_->geom_bodyid[geom])];
      if (robot < 0) continue;
      PitchRobot& r = robot_[index(robot)];
      const int other = geom == c.geom1 ? c.geom2 : c.geom1;
      if (ball_body_ >= 0 && model_->geom_bodyid[other] == ball_body_) ball_.touched_by = robot;
      const int side = sole_of_geom_[index(geom)];
      if (side < 0) {
        const bool ground = model_->geom_contype[other] & kUneven;
        r.truth.body_down = r.truth.body_down || (ground && c.efc_address >= 0);
        continue;
      }
      mjtNum force[6];
      mj_contactForce(model_.get(), data_.get(), i, force);
      const Sole& sole = *r.soles[index(side)];
      const mjtNum* const turn = data_->geom_xmat + 9 * geom;  // rows: world, columns: the box's axes
      const Vec3 from = vec_of(c.pos) - vec_of(data_->geom_xpos + 3 * geom);
      const Vec3 at{turn[0] * from.x + turn[3] * from.y + turn[6] * from.z,
                    turn[1] * from.x + turn[4] * from.y + turn[7] * from.z,
                    turn[2] * from.x + turn[5] * from.y + turn[8] * from.z};
      // A cell feels what comes from below, along the sole's own z.
      const Vec3 normal = vec_of(c.frame);
      const double up_n = force[0] * math::fabs(turn[2] * normal.x + turn[5] * normal.y + turn[8] * normal.z);
      if (at.z > 0) continue;
      r.truth.foot_n[index(side)] += up_n;
      const auto shares = cell_shares(sole, at);
      for (std::size_t k = 0; k < 4; ++k) r.measured.cell_n[index(side)][k] += up_n * shares[k];
    }
  }
}

void DynamicPitch::look_at(std::size_t robot, bool first) {
  PitchRobot& r = robot_[robot];
  InModel& at = at_[robot];
  BodyTruth& t = r.truth;
  for (std::size_t l = 0; l < at.link_body.size(); ++l)
    t.link[l] = {vec_of(data_->xpos + 3 * at.link_body[l]), quat_of(data_->xquat + 4 * at.link_body[l])};
  t.torso = t.link[0];
  t.v_world_mps = vec_of(data_->qvel + at.base_dof);
  t.gyro_radps = vec_of(data_->qvel + at.base_dof + 3);
  const double up = t.torso.q.rotate({0, 0, 1}).z;
  t.tilt_rad = math::acos(std::clamp(up, -1.0, 1.0));
  t.fallen = up < kFallenCosine;
  for (std::size_t j = 0; j < at.joint_qpos.size(); ++j) {
    t.joint_rad[j] = data_->qpos[at.joint_qpos[j]];
    t.joint_radps[j] = data_->qvel[at.joint_dof[j]];
    r.measured.joint[j] = {r.servo[j].encoder_rad(t.joint_rad[j]),
                           kSpeedStep_radps * math::round(t.joint_radps[j] / kSpeedStep_radps), r.servo[j].motor_nm(),
                           r.servo[j].temperature_c()};
  }
  // The IMU: what its place feels on the average of the step.
  const int object = at.imu_site >= 0 ? at.imu_site : at.link_body[0];
  mjtNum motion[6];
  mj_objectVelocity(model_.get(), data_.get(), at.imu_site >= 0 ? mjOBJ_SITE : mjOBJ_BODY, object, motion, 0);
  mjtNum q[4];
  if (at.imu_site >= 0)
    mju_mat2Quat(q, data_->site_xmat + 9 * object);
  else
    std::copy_n(data_->xquat + 4 * object, 4, q);
  const Quat imu_world = quat_of(q).conjugate();
  const Vec3 v = vec_of(motion + 3);
  const Vec3 felt = (first ? Vec3{} : (v - at.imu_mps) / kStep_s) + Vec3{0, 0, kGravity_mps2};
  at.imu_mps = v;
  r.measured.gyro_radps = imu_world.rotate(vec_of(motion));
  r.measured.accel_mps2 = imu_world.rotate(felt);
}

void DynamicPitch::look_at_ball() {
  if (ball_body_ < 0) return;
  ball_.p_m = vec_of(data_->xpos + 3 * ball_body_);
  ball_.v_mps = vec_of(data_->qvel + ball_dof_);
  ball_.q = quat_of(data_->xquat + 4 * ball_body_);
  ball_.spin_radps = ball_.q.rotate(vec_of(data_->qvel + ball_dof_ + 3));
}

void DynamicPitch::step() {
  for (std::size_t i = 0; i < robot_.size(); ++i) drive(i);
  brake_ball();
  // mj_step() in its two halves, so that contacts still have their forces, and places are those of the new state.
  mj_step2(model_.get(), data_.get());
  now_ns_ += kPitchStepNs;
  feel_contacts();
  mj_step1(model_.get(), data_.get());
  for (std::size_t i = 0; i < robot_.size(); ++i) {
    look_at(i, false);
    robot_[i].io.measure(robot_[i].measured, now_ns_);
  }
  look_at_ball();
}

}  // namespace

hal::Result<std::unique_ptr<Pitch>> create_dynamic_pitch(const PitchOptions& options, std::span<const PitchBody> bodies,
                                                         std::uint64_t seed) {
  std::vector<PitchRobot> robots = robots_of(bodies, seed);
  std::vector<ModelRobot> models;
  for (const PitchRobot& r : robots) models.push_back(r.model);
  auto model = load_room(pitch_xml(options, models), RoomUse::physics);
  if (!model) return model.error();
  use_own_ground_contacts();
  auto pitch = std::make_unique<DynamicPitch>(options, std::move(robots), std::move(*model), seed);
  pitch->start(bodies);
  return std::unique_ptr<Pitch>(std::move(pitch));
}

}  // namespace sinew::plant
