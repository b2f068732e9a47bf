#include "robots/quad/world/quad_world.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "math/random.hpp"
#include "robots/quad/world/rotors.hpp"
#include "robots/quad/world/wind.hpp"
#include "sim_hil/mujoco/room.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/sensors.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::robots {
std::string_view room_xml_of_quad();  // of room.xml, made by CMake
}

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

std::array<double, kRotors> spread_thrust(math::Random& noise, double spread) {
  std::array<double, kRotors> f;
  for (double& x : f) x = 1.0 + spread * noise.uniform(-1, 1);
  return f;
}

}  // namespace

WorldInfo QuadWorld::info() { return {"quad", kQuadDevices}; }

struct QuadWorld::Impl {
  Impl(const QuadOptions& o, ModelPtr m)
      : options(o),
        noise(o.seed, 0x706c616e),
        model(std::move(m)),
        data(mj_makeData(model.get())),
        factor(spread_thrust(noise, o.spread)),
        propulsion(factor, 1.0 - 0.15 * noise.uniform()),
        wind(o.gust_mps, o.seed),
        imu(imu_errors(o.sensor_errors), o.seed),
        range(range_errors(o.sensor_errors), o.seed),
        baro(baro_errors(o.sensor_errors), o.seed),
        battery(battery_errors(o.sensor_errors), o.seed) {
    body = mj_name2id(model.get(), mjOBJ_BODY, "quad");
    hull = mj_name2id(model.get(), mjOBJ_GEOM, "hull");
    first_foot = mj_name2id(model.get(), mjOBJ_GEOM, "foot_fl");  // the other three follow it in the file
    spread_mass();
    start_pose();
    mj_forward(model.get(), data.get());  // static geoms get their world poses here
  }

  void spread_mass() {
    const double f = 1.0 + options.spread * noise.uniform(-1, 1);
    model->body_mass[body] *= f;
    for (int i = 0; i < 3; ++i) model->body_inertia[3 * body + i] *= f;
    mj_setConst(model.get(), data.get());
  }

  void start_pose() {
    double x = 0, y = 0;
    do {
      x = noise.uniform(-1, 1);
      y = noise.uniform(-1, 1);
    } while (x * x + y * y > 1.0);
    // Half the yaw angle is small: a unit quaternion from its tangent's series, normalised.
    const double half = 0.5 * options.start_yaw_rad * noise.uniform(-1, 1);
    const double norm = 1.0 / std::sqrt(1.0 + half * half);
    set_pose({x * options.start_offset_m, y * options.start_offset_m, kFeetBelowBase}, {norm, 0, 0, half * norm}, {});
  }

  void set_pose(const msg::Vec3& p, const msg::Quat& q, const msg::Vec3& v) {
    double* qpos = data->qpos;
    qpos[0] = p.x, qpos[1] = p.y, qpos[2] = p.z;
    qpos[3] = q.w, qpos[4] = q.x, qpos[5] = q.y, qpos[6] = q.z;
    double* qvel = data->qvel;
    qvel[0] = v.x, qvel[1] = v.y, qvel[2] = v.z;
    qvel[3] = qvel[4] = qvel[5] = 0;
    std::fill(data->qacc_warmstart, data->qacc_warmstart + 6, 0.0);
  }

  msg::Vec3 position() const { return {data->qpos[0], data->qpos[1], data->qpos[2]}; }
  msg::Vec3 velocity() const { return {data->qvel[0], data->qvel[1], data->qvel[2]}; }
  msg::Vec3 rates() const { return {data->qvel[3], data->qvel[4], data->qvel[5]}; }
  msg::Quat attitude() const { return {data->qpos[3], data->qpos[4], data->qpos[5], data->qpos[6]}; }
  msg::Time now() const { return {steps * kStepNs}; }

  double rotor_share() const {  // mean share of full speed
    double sum = 0;
    for (const double w : propulsion.omega_radps()) sum += w;
    return sum / (kRotors * RotorParams{}.omega_max_radps);
  }

  void apply_forces(const std::array<double, kRotors>& command);
  void integrate();
  void watch_contacts(const msg::Vec3& v_before);
  void sample();
  double true_range() const;
  int feet_down() const;

  QuadOptions options;
  math::Random noise;
  ModelPtr model;
  DataPtr data;
  std::array<double, kRotors> factor;
  Propulsion propulsion;
  Wind wind;
  ImuModel imu;
  RangeModel range;
  BaroModel baro;
  BatteryModel battery;
  int body = 0, hull = 0, first_foot = 0;
  std::int64_t steps = 0;
  std::uint32_t next_frame = 1;
  int clear_steps = 0;
  msg::Vec3 force_specific;       // specific force of the last step, base
  msg::Vec3 gyro_sum, accel_sum;  // since the last IMU sample
  Due due;
  FlightSummary summary;
};

void QuadWorld::Impl::apply_forces(const std::array<double, kRotors>& command) {
  const Rotation r(attitude());
  const msg::Vec3& air_world = wind.step(kStepS);
  Wrench w = propulsion.step(command, data->qpos[2] + kRotorMounts[0].p_base_m.z, kStepS);
  if (options.drag) {
    const DragParams drag;
    w.force_n = add(w.force_n, drag_force(drag, r.inverse(sub(velocity(), air_world))));
    const msg::Vec3 rate = rates();
    w.torque_nm.x -= drag.angular_nm_per_radps.x * rate.x;
    w.torque_nm.y -= drag.angular_nm_per_radps.y * rate.y;
    w.torque_nm.z -= drag.angular_nm_per_radps.z * rate.z;
  }
  const msg::Vec3 f = r.apply(w.force_n);
  double* q = data->qfrc_applied;  // of a free joint: force in the world frame, torque in the body's
  q[0] = f.x, q[1] = f.y, q[2] = f.z, q[3] = w.torque_nm.x, q[4] = w.torque_nm.y, q[5] = w.torque_nm.z;
}

void QuadWorld::Impl::integrate() {
  const Rotation before(attitude());
  const double* a = data->qacc;
  force_specific = before.inverse({a[0], a[1], a[2] + kGravity});
  accel_sum = add(accel_sum, force_specific);
  double* v = data->qvel;
  for (int i = 0; i < 6; ++i) v[i] += kStepS * a[i];
  for (int i = 0; i < 3; ++i) data->qpos[i] += kStepS * v[i];
  const msg::Quat q = turn(attitude(), v + 3, kStepS);
  data->qpos[3] = q.w, data->qpos[4] = q.x, data->qpos[5] = q.y, data->qpos[6] = q.z;
  gyro_sum = add(gyro_sum, rates());
  std::copy(a, a + 6, data->qacc_warmstart);
  ++steps;
}

void QuadWorld::Impl::watch_contacts(const msg::Vec3& v_before) {
  const msg::Vec3 p = position();
  summary.max_height_m = std::max(summary.max_height_m, p.z);
  const bool contact = data->ncon > 0;
  clear_steps = p.z > kFeetBelowBase + kClearM ? clear_steps + 1 : 0;
  if (clear_steps >= kFlewSteps) summary.flew = true;
  for (int i = 0; i < data->ncon; ++i)
    if (data->contact[i].geom1 == hull || data->contact[i].geom2 == hull) summary.crashed = true;
  if (!contact || !summary.flew || summary.touched_down) return;
  summary.touched_down = true;
  summary.touchdown_at = now();
  summary.touchdown_speed_mps = -v_before.z;
  summary.touchdown_drift_mps = std::sqrt(v_before.x * v_before.x + v_before.y * v_before.y);
  summary.touchdown_error_m = std::sqrt(p.x * p.x + p.y * p.y);
}

double QuadWorld::Impl::true_range() const {
  const Rotation r(attitude());
  const msg::Vec3 from = add(position(), r.apply(kRangePBase)), along = r.apply({0, 0, -1});
  const mjtNum pnt[3] = {from.x, from.y, from.z}, vec[3] = {along.x, along.y, along.z};
  constexpr mjtByte kRoomOnly[6] = {1, 0, 0, 0, 0, 0};
  int geom = -1;
  return mj_ray(model.get(), data.get(), pnt, vec, kRoomOnly, 1, body, &geom);
}

int QuadWorld::Impl::feet_down() const {
  unsigned feet = 0;
  for (int i = 0; i < data->ncon; ++i)
    for (const int geom : {data->contact[i].geom1, data->contact[i].geom2})
      if (geom >= first_foot && geom < first_foot + 4) feet |= 1u << (geom - first_foot);
  return std::popcount(feet);
}

void QuadWorld::Impl::sample() {
  due.imu = steps % kImuSteps == 0;
  due.range = steps % kRangeSteps == 0;
  due.baro = steps % kBaroSteps == 0;
  due.battery = steps % kBatterySteps == 0;
  due.truth = steps % kTruthSteps == 0;
  due.camera = now().ns == camera_stamp_ns(next_frame);
  if (due.camera) ++next_frame;
  if (due.imu) {
    due.imu_sample = imu.measure(scale(gyro_sum, 1.0 / kImuSteps), scale(accel_sum, 1.0 / kImuSteps), rotor_share(),
                                 kImuSteps * kStepS);
    due.imu_sample.stamp = {now().ns - kImuSteps * kStepNs / 2};  // the middle of the interval averaged over
    gyro_sum = accel_sum = {};
  }
  if (due.range) {
    due.range_sample.range_m = range.measure(true_range());
    due.range_sample.stamp = now();
  }
  if (due.baro) {
    const double share = rotor_share();
    due.baro_sample = baro.measure(data->qpos[2], share * share, kBaroSteps * kStepS);
    due.baro_sample.stamp = now();
  }
  if (due.battery) {
    due.battery_sample = battery.measure(propulsion.voltage_v(), propulsion.current_a(), propulsion.charge());
    due.battery_sample.stamp = now();
  }
}

QuadWorld::QuadWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
QuadWorld::~QuadWorld() = default;

hal::Result<std::unique_ptr<QuadWorld>> QuadWorld::create(const QuadOptions& options) {
  auto model = load_room(robots::room_xml_of_quad(), RoomUse::physics);
  if (!model) return model.error();
  return std::unique_ptr<QuadWorld>(new QuadWorld(std::make_unique<Impl>(options, std::move(*model))));
}

const Due& QuadWorld::step(std::span<const double> command) {
  Impl& w = *impl_;
  std::array<double, kRotors> motors{};
  std::copy_n(command.begin(), std::min(command.size(), kRotors), motors.begin());
  const msg::Vec3 v_before = w.velocity();
  w.apply_forces(motors);
  mj_forwardSkip(w.model.get(), w.data.get(), mjSTAGE_NONE, 1);
  w.integrate();
  w.watch_contacts(v_before);
  w.sample();
  return w.due;
}

msg::Time QuadWorld::now() const { return impl_->now(); }
const FlightSummary& QuadWorld::summary() const { return impl_->summary; }
double QuadWorld::mass_kg() const { return impl_->model->body_mass[impl_->body]; }
const std::array<double, kRotors>& QuadWorld::thrust_factor() const { return impl_->factor; }

TruthState QuadWorld::truth() const {
  const Impl& w = *impl_;
  TruthState t;
  t.stamp = w.now();
  t.p_world_m = w.position();
  t.v_world_mps = w.velocity();
  t.q_world_base = w.attitude();
  t.gyro_radps = w.rates();
  t.accel_mps2 = w.force_specific;
  t.wind_world_mps = w.wind.velocity_mps();
  t.omega_radps = w.propulsion.omega_radps();
  t.voltage_v = w.propulsion.voltage_v();
  t.current_a = w.propulsion.current_a();
  t.charge = w.propulsion.charge();
  t.contact = w.data->ncon > 0;
  t.feet_down = w.feet_down();
  t.on_pad = t.contact && t.p_world_m.x * t.p_world_m.x + t.p_world_m.y * t.p_world_m.y < kPadRadius * kPadRadius;
  return t;
}

CameraPose QuadWorld::camera_pose() const {
  const Rotation r(impl_->attitude());
  return {add(impl_->position(), r.apply(kCameraPBase)), mul(impl_->attitude(), kCameraQBaseOptical)};
}

WorldTruth QuadWorld::ground_truth() const {
  const TruthState t = truth();
  return {t.p_world_m, t.v_world_mps, t.q_world_base, t.gyro_radps, {}, t.voltage_v, t.contact, t.feet_down == 4};
}

bool QuadWorld::at_rest() const {
  // The physics' contacts have no rolling friction: a vehicle that has fallen on its side rocks for long.
  constexpr double kStill_mps = 0.15, kStill_radps = 2.0;
  const auto norm2 = [](const msg::Vec3& v) { return v.x * v.x + v.y * v.y + v.z * v.z; };
  return impl_->data->ncon > 0 && norm2(impl_->velocity()) < kStill_mps * kStill_mps &&
         norm2(impl_->rates()) < kStill_radps * kStill_radps;
}

bool QuadWorld::motors_stopped() const {
  constexpr double kStill_radps = 0.01 * RotorParams{}.omega_max_radps;
  return std::ranges::all_of(impl_->propulsion.omega_radps(), [](double w) { return w < kStill_radps; });
}

double QuadWorld::pad_distance_m() const {
  const msg::Vec3 p = impl_->position();
  return std::sqrt(p.x * p.x + p.y * p.y);
}

void QuadWorld::add_to(JsonObject& j) const {
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

Verdict QuadWorld::verdict() const {
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

std::string QuadWorld::outcome() const {
  const FlightSummary& flight = summary();
  if (!flight.touched_down) return flight.flew ? "flew, has not touched down" : "did not fly";
  char text[160];
  std::snprintf(text, sizeof text, "touched down at %.2f s with %.2f m/s; now %.3f m from the pad's centre%s",
                msg::seconds(flight.touchdown_at), flight.touchdown_speed_mps, pad_distance_m(),
                flight.crashed ? ", crashed" : "");
  return text;
}

void QuadWorld::place(const msg::Vec3& p_world_m, const msg::Quat& q_world_base, const msg::Vec3& v_world_mps) {
  impl_->set_pose(p_world_m, q_world_base, v_world_mps);
}

}  // namespace sinew::plant
