#include "robots/quad/world/quad.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "math/elementary.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::plant {
namespace {

constexpr double kStepS = 1e-9 * kStepNs;
constexpr int kFlewSteps = static_cast<int>(500'000'000 / kStepNs);
constexpr double kClearM = 0.1;

/// Turns `q` by the angular velocity `w` (base frame) over `dt_s`, with sin and cos as series: at 50 rad/s the angle
/// is 0.006 rad and the series is exact to the last bit or two.
msg::Quat turn(const msg::Quat& q, const double* w, double dt_s) {
  const double hx = 0.5 * dt_s * w[0], hy = 0.5 * dt_s * w[1], hz = 0.5 * dt_s * w[2];
  const double s = hx * hx + hy * hy + hz * hz;
  const double sinc = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0));
  const double cosine = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0));
  msg::Quat r = mul(q, {cosine, sinc * hx, sinc * hy, sinc * hz});
  const double norm = 1.0 / std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
  return {r.w * norm, r.x * norm, r.y * norm, r.z * norm};
}

msg::Vec3 drag_force(const DragParams& drag, const msg::Vec3& air) {
  const auto axis = [](double linear, double quadratic, double v) { return -v * (linear + quadratic * std::fabs(v)); };
  return {axis(drag.linear_n_per_mps.x, drag.quadratic_n_per_m2ps2.x, air.x),
          axis(drag.linear_n_per_mps.y, drag.quadratic_n_per_m2ps2.y, air.y),
          axis(drag.linear_n_per_mps.z, drag.quadratic_n_per_m2ps2.z, air.z)};
}

ImuErrors imu_errors(bool on) { return on ? ImuErrors{} : ImuErrors{0, 0, 0, 0, 0, 0, 0, 0}; }
RangeErrors range_errors(bool on) {
  RangeErrors e;
  if (!on) e.noise_m = e.noise_share = 0;
  return e;
}
BaroErrors baro_errors(bool on) {
  BaroErrors e;
  if (!on) e.noise_pa = e.walk_pa = e.wash_pa = 0;
  return e;
}

BatteryErrors battery_errors(bool on) { return on ? BatteryErrors{} : BatteryErrors{0, 0, 0, 0, 0}; }

/// Draws in any case, so that what is drawn later does not depend on the option.
double drawn_charge(math::Random& noise, std::optional<double> wanted) {
  const double drawn = 1.0 - 0.15 * noise.uniform();
  return wanted.value_or(drawn);
}

std::array<double, kRotors> spread_thrust(math::Random& noise, double spread) {
  std::array<double, kRotors> f;
  for (double& x : f) x = 1.0 + spread * noise.uniform(-1, 1);
  return f;
}

/// The name of a part of vehicle `number` in the room.
std::string part_name(const char* name, std::size_t number) {
  return number == 0 ? std::string(name) : name + std::to_string(number);
}

}  // namespace

Quad::Quad(const QuadOptions& o, mjModel& model, mjData& data, std::size_t number, std::span<const Quad* const> all)
    : options_(o),
      model_(model),
      data_(data),
      number_(number),
      all_(all),
      noise_(o.seed, 0x706c616e),
      factor_(spread_thrust(noise_, o.spread)),
      propulsion_(factor_, drawn_charge(noise_, o.battery_charge)),
      imu_(imu_errors(o.sensor_errors), o.seed),
      range_(range_errors(o.sensor_errors), o.seed),
      baro_(baro_errors(o.sensor_errors), o.seed),
      battery_(battery_errors(o.sensor_errors), o.seed) {
  body_ = mj_name2id(&model_, mjOBJ_BODY, part_name("quad", number).c_str());
  hull_ = mj_name2id(&model_, mjOBJ_GEOM, part_name("hull", number).c_str());
  first_foot_ = mj_name2id(&model_, mjOBJ_GEOM, part_name("foot_fl", number).c_str());  // the other three follow it
  spread_mass();
}

void Quad::spread_mass() {
  const double f = 1.0 + options_.spread * noise_.uniform(-1, 1);
  model_.body_mass[body_] *= f;
  for (int i = 0; i < 3; ++i) model_.body_inertia[3 * body_ + i] *= f;
  mj_setConst(&model_, &data_);
}

bool Quad::start() {
  constexpr double kApart_m = 0.7;
  constexpr int kTries = 1000;
  for (int i = 0; i < kTries; ++i) {
    double x = 0, y = 0;
    do {
      x = noise_.uniform(-1, 1);
      y = noise_.uniform(-1, 1);
    } while (x * x + y * y > 1.0);
    const msg::Vec3 p{options_.start_x_m.value_or(x * options_.start_offset_m),
                      options_.start_y_m.value_or(y * options_.start_offset_m), kFeetBelowBase};
    const auto is_near = [&](const Quad* other) {
      const msg::Vec3 d = sub(other->position(), p);
      return d.x * d.x + d.y * d.y < kApart_m * kApart_m;
    };
    if (std::ranges::any_of(all_.first(number_), is_near)) continue;
    // Half the yaw angle is small: a unit quaternion from its tangent's series, normalised.
    const double half = 0.5 * options_.start_yaw_rad * noise_.uniform(-1, 1);
    const double norm = 1.0 / std::sqrt(1.0 + half * half);
    msg::Quat q{norm, 0, 0, half * norm};
    if (options_.start_heading_rad) {
      const auto turned = math::sincos(*options_.start_heading_rad / 2);
      q = {turned.cos, 0, 0, turned.sin};
    }
    place(p, q);
    return true;
  }
  return false;
}

void Quad::place(const msg::Vec3& p, const msg::Quat& q, const msg::Vec3& v) {
  double* qpos = data_.qpos + 7 * number_;
  qpos[0] = p.x, qpos[1] = p.y, qpos[2] = p.z;
  qpos[3] = q.w, qpos[4] = q.x, qpos[5] = q.y, qpos[6] = q.z;
  double* qvel = data_.qvel + 6 * number_;
  qvel[0] = v.x, qvel[1] = v.y, qvel[2] = v.z;
  qvel[3] = qvel[4] = qvel[5] = 0;
  std::fill_n(data_.qacc_warmstart + 6 * number_, 6, 0.0);
}

msg::Vec3 Quad::position() const {
  const double* p = data_.qpos + 7 * number_;
  return {p[0], p[1], p[2]};
}
msg::Vec3 Quad::velocity() const {
  const double* v = data_.qvel + 6 * number_;
  return {v[0], v[1], v[2]};
}
msg::Vec3 Quad::rates() const {
  const double* v = data_.qvel + 6 * number_;
  return {v[3], v[4], v[5]};
}
msg::Quat Quad::attitude() const {
  const double* p = data_.qpos + 7 * number_;
  return {p[3], p[4], p[5], p[6]};
}

double Quad::distance_m(const msg::Vec3& p) const {
  const double x = p.x - options_.land_x_m, y = p.y - options_.land_y_m;
  return std::sqrt(x * x + y * y);
}

double Quad::rotor_share() const {  // mean share of full speed
  double sum = 0;
  for (const double w : propulsion_.omega_radps()) sum += w;
  return sum / (kRotors * RotorParams{}.omega_max_radps);
}

void Quad::apply_forces(RobotCommand given, const msg::Vec3& air_world) {
  std::array<double, kRotors> command{};
  std::copy_n(given.begin(), std::min(given.size(), kRotors), command.begin());
  v_before_ = velocity();
  wind_ = air_world;
  const Rotation r(attitude());
  summary_.wind_max_mps =
      std::max(summary_.wind_max_mps,
               std::sqrt(air_world.x * air_world.x + air_world.y * air_world.y + air_world.z * air_world.z));
  Wrench w = propulsion_.step(command, position().z + kRotorMounts[0].p_base_m.z, kStepS);
  if (options_.drag) {
    const DragParams drag;
    w.force_n = add(w.force_n, drag_force(drag, r.inverse(sub(velocity(), air_world))));
    const msg::Vec3 rate = rates();
    w.torque_nm.x -= drag.angular_nm_per_radps.x * rate.x;
    w.torque_nm.y -= drag.angular_nm_per_radps.y * rate.y;
    w.torque_nm.z -= drag.angular_nm_per_radps.z * rate.z;
  }
  const msg::Vec3 f = r.apply(w.force_n);
  // Of a free joint: force in the world frame, torque in the body's.
  double* q = data_.qfrc_applied + 6 * number_;
  q[0] = f.x, q[1] = f.y, q[2] = f.z, q[3] = w.torque_nm.x, q[4] = w.torque_nm.y, q[5] = w.torque_nm.z;
}

bool Quad::accelerate_freely() {
  const msg::Vec3 p = position();
  const double aside = std::max(std::fabs(p.x), std::fabs(p.y));
  // The hull reaches 0.26 m, and 0.2 m downwards with feet while it leans by less than 37 degrees. No obstacle within
  // 1.8 m reaches up to 0.7 m (room.xml).
  const double least_z = Rotation(attitude()).apply({0, 0, 1}).z > 0.8 ? 0.25 : 0.4;
  const bool free = p.z < 3.5 && ((p.z > least_z && aside < kClear_m - 0.3) || (p.z > 1 && aside < 1.5));
  if (!options_.free_flight || !free) return false;
  const double *f = data_.qfrc_applied + 6 * number_, *w = data_.qvel + 6 * number_ + 3;
  const double* inertia = model_.body_inertia + 3 * body_;
  double* a = data_.qacc + 6 * number_;
  for (int i = 0; i < 3; ++i) a[i] = f[i] / mass_kg();
  a[2] -= kGravity;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    a[3 + i] = (f[3 + i] - w[j] * w[k] * (inertia[k] - inertia[j])) / inertia[i];
  }
  data_.ncon = 0;
  return true;
}

void Quad::integrate() {
  const Rotation before(attitude());
  const double* a = data_.qacc + 6 * number_;
  force_specific_ = before.inverse({a[0], a[1], a[2] + kGravity});
  accel_sum_ = add(accel_sum_, force_specific_);
  double* v = data_.qvel + 6 * number_;
  double* p = data_.qpos + 7 * number_;
  for (int i = 0; i < 6; ++i) v[i] += kStepS * a[i];
  for (int i = 0; i < 3; ++i) p[i] += kStepS * v[i];
  const msg::Quat q = turn(attitude(), v + 3, kStepS);
  p[3] = q.w, p[4] = q.x, p[5] = q.y, p[6] = q.z;
  gyro_sum_ = add(gyro_sum_, rates());
  std::copy_n(a, 6, data_.qacc_warmstart + 6 * number_);
}

bool Quad::touches() const {
  for (int i = 0; i < data_.ncon; ++i)
    for (const int geom : {data_.contact[i].geom1, data_.contact[i].geom2})
      if (model_.geom_bodyid[geom] == body_) return true;
  return false;
}

void Quad::watch_contacts(msg::Time now) {
  now_ = now;
  const msg::Vec3 p = position();
  summary_.max_height_m = std::max(summary_.max_height_m, p.z);
  clear_steps_ = p.z > kFeetBelowBase + kClearM ? clear_steps_ + 1 : 0;
  if (clear_steps_ >= kFlewSteps) summary_.flew = true;
  for (int i = 0; i < data_.ncon; ++i) {
    const int one = data_.contact[i].geom1, other = data_.contact[i].geom2;
    const int bodies[] = {model_.geom_bodyid[one], model_.geom_bodyid[other]};
    const bool own = bodies[0] == body_ || bodies[1] == body_, vehicles = bodies[0] != 0 && bodies[1] != 0;
    if (one == hull_ || other == hull_ || (own && vehicles)) summary_.crashed = true;
  }
  if (!summary_.flew || summary_.touched_down || !touches()) return;
  summary_.touched_down = true;
  summary_.touchdown_at = now;
  summary_.touchdown_speed_mps = -v_before_.z;
  summary_.touchdown_drift_mps = std::sqrt(v_before_.x * v_before_.x + v_before_.y * v_before_.y);
  summary_.touchdown_error_m = distance_m(p);
}

double Quad::true_range() const {
  const Rotation r(attitude());
  const msg::Vec3 from = add(position(), r.apply(kRangePBase)), along = r.apply({0, 0, -1});
  const mjtNum pnt[3] = {from.x, from.y, from.z}, vec[3] = {along.x, along.y, along.z};
  constexpr mjtByte kRoomAndHulls[6] = {1, 0, 0, 1, 0, 0};
  int geom = -1;
  return mj_ray(&model_, &data_, pnt, vec, kRoomAndHulls, 1, body_, &geom);
}

int Quad::feet_down() const {
  unsigned feet = 0;
  for (int i = 0; i < data_.ncon; ++i)
    for (const int geom : {data_.contact[i].geom1, data_.contact[i].geom2})
      if (geom >= first_foot_ && geom < first_foot_ + 4) feet |= 1u << (geom - first_foot_);
  return std::popcount(feet);
}

void Quad::sample(std::int64_t steps) {
  due_.imu = steps % kImuSteps == 0;
  due_.range = steps % kRangeSteps == 0;
  due_.baro = steps % kBaroSteps == 0;
  due_.battery = steps % kBatterySteps == 0;
  due_.truth = steps % kTruthSteps == 0;
  due_.cameras = now_.ns == camera_stamp_ns(next_frame_);
  if (due_.cameras != 0) ++next_frame_;
  if (due_.imu) {
    due_.imu_sample = imu_.measure(scale(gyro_sum_, 1.0 / kImuSteps), scale(accel_sum_, 1.0 / kImuSteps), rotor_share(),
                                   kImuSteps * kStepS);
    due_.imu_sample.stamp = {now_.ns - kImuSteps * kStepNs / 2};  // the middle of the interval averaged over
    gyro_sum_ = accel_sum_ = {};
  }
  if (due_.range) {
    due_.range_sample.range_m = range_.measure(true_range());
    due_.range_sample.stamp = now_;
  }
  if (due_.baro) {
    const double share = rotor_share();
    due_.baro_sample = baro_.measure(position().z, share * share, kBaroSteps * kStepS);
    due_.baro_sample.stamp = now_;
  }
  if (due_.battery) {
    due_.battery_sample = battery_.measure(propulsion_.voltage_v(), propulsion_.current_a(), propulsion_.charge());
    due_.battery_sample.stamp = now_;
  }
}

double Quad::mass_kg() const { return model_.body_mass[body_]; }

TruthState Quad::truth() const {
  TruthState t;
  t.stamp = now_;
  t.p_world_m = position();
  t.v_world_mps = velocity();
  t.q_world_base = attitude();
  t.gyro_radps = rates();
  t.accel_mps2 = force_specific_;
  t.wind_world_mps = wind_;
  t.omega_radps = propulsion_.omega_radps();
  t.voltage_v = propulsion_.voltage_v();
  t.current_a = propulsion_.current_a();
  t.charge = propulsion_.charge();
  t.contact = touches();
  t.feet_down = feet_down();
  t.on_pad = t.contact && pad_distance_m() < kPadRadius;
  return t;
}

CameraPose Quad::camera_pose() const {
  const Rotation r(attitude());
  return {add(position(), r.apply(kCameraPBase)), mul(attitude(), kCameraQBaseOptical)};
}

Scene Quad::scene(std::size_t /*camera*/) const {
  Scene scene;
  scene.camera = camera_pose();
  if (all_.size() == 1) return scene;
  constexpr msg::Vec3 kOutOfSight{0, 0, -50};  // its own body is above its camera
  scene.vehicles = all_.size();
  for (std::size_t i = 0; i < all_.size(); ++i)
    scene.vehicle[i] = {i == number_ ? kOutOfSight : all_[i]->position(), all_[i]->attitude()};
  scene.rotors_turn = std::ranges::any_of(all_, [](const Quad* quad) { return !quad->motors_stopped(); });
  return scene;
}

WorldTruth Quad::ground_truth() const {
  const TruthState t = truth();
  return {t.p_world_m, t.v_world_mps, t.q_world_base,  t.gyro_radps, {options_.land_x_m, options_.land_y_m, 0},
          t.voltage_v, t.contact,     t.feet_down == 4};
}

bool Quad::at_rest() const {
  // The physics' contacts have no rolling friction: a vehicle that has fallen on its side rocks for long.
  constexpr double kStill_mps = 0.15, kStill_radps = 2.0;
  const auto norm2 = [](const msg::Vec3& v) { return v.x * v.x + v.y * v.y + v.z * v.z; };
  return touches() && norm2(velocity()) < kStill_mps * kStill_mps && norm2(rates()) < kStill_radps * kStill_radps;
}

bool Quad::motors_stopped() const {
  constexpr double kStill_radps = 0.01 * RotorParams{}.omega_max_radps;
  return std::ranges::all_of(propulsion_.omega_radps(), [](double w) { return w < kStill_radps; });
}

double Quad::pad_distance_m() const { return distance_m(position()); }

void Quad::add_to(JsonObject& j) const {
  const TruthState last = truth();
  const FlightSummary& flight = summary();
  j.number("mass_kg", mass_kg());
  j.boolean("flew", flight.flew);
  j.boolean("crashed", flight.crashed);
  j.boolean("touched_down", flight.touched_down);
  j.number("max_height_m", flight.max_height_m);
  if (flight.touched_down) {
    j.number("touchdown_s", msg::seconds(flight.touchdown_at));
    j.number("touchdown_speed_mps", flight.touchdown_speed_mps);
    j.number("touchdown_drift_mps", flight.touchdown_drift_mps);
    j.number("touchdown_error_m", flight.touchdown_error_m);
    j.number("landing_error_m", pad_distance_m());
  }
  j.number("pad_distance_m", pad_distance_m());
  j.boolean("on_pad", last.on_pad);
  j.number("height_m", last.p_world_m.z);
  j.number("battery_v", last.voltage_v);
  j.boolean("at_rest", at_rest());
  j.boolean("motors_stopped", motors_stopped());
}

Verdict Quad::verdict() const {
  constexpr double kMostError_m = 0.15, kMostSpeed_mps = 0.5;
  const FlightSummary& flight = summary();
  const double error_m = pad_distance_m();
  const bool soft = flight.touchdown_speed_mps < kMostSpeed_mps;
  Verdict verdict;
  verdict.begun = flight.flew;
  if (flight.touched_down)
    verdict.measures = {{"landing_error_m", "landing error", "m", error_m, kMostError_m},
                        {"touchdown_speed_mps", "touchdown speed", "m/s", flight.touchdown_speed_mps, kMostSpeed_mps},
                        {"flight_s", "flight time", "s", msg::seconds(flight.touchdown_at)}};
  verdict.conditions = {{"wind_max_mps", "strongest wind", "m/s", flight.wind_max_mps, QuadOptions{}.gust_mps}};
  if (flight.crashed)
    verdict.outcome = "crashed";
  else if (!flight.touched_down)
    verdict.outcome = "did not land";
  else if (!soft)
    verdict.outcome = "landed hard";
  else if (error_m >= kMostError_m)
    verdict.outcome = "landed off the pad";
  else
    verdict.outcome = "landed on the pad";
  verdict.good = flight.touched_down && !flight.crashed && soft && error_m < kMostError_m;
  return verdict;
}

std::string Quad::outcome() const {
  const FlightSummary& flight = summary();
  if (!flight.touched_down) return flight.flew ? "flew, has not touched down" : "did not fly";
  char text[160];
  std::snprintf(text, sizeof text, "touched down at %.2f s with %.2f m/s; now %.3f m from the pad's centre%s",
                msg::seconds(flight.touchdown_at), flight.touchdown_speed_mps, pad_distance_m(),
                flight.crashed ? ", crashed" : "");
  return text;
}

}  // namespace sinew::plant
