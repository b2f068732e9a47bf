#include "sim_hil/places/vehicle.hpp"

#include <algorithm>
#include <cstdio>

#include "sim_hil/places/place.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {

using math::Quat;
using math::Vec3;

namespace {

constexpr int kVehicleRangeSteps = 40, kVehicleBaroSteps = 80, kVehicleBatterySteps = 400, kVehicleJointSteps = 40;
constexpr double kVehicleStep_s = 1e-9 * kStepNs;
constexpr double kMostRange_m = 6;
// The goal: so near to the target, horizontally, lately; and in view for so much of the time since it was found.
// The target is found when it was near the middle of the picture for so long.
constexpr double kMiddle_rad = 0.105, kFound_s = 0.5;
constexpr double kReached_m = 0.30, kLately_s = 1.0, kInView = 0.98;
constexpr double kCameraLag_s = 0.05;
constexpr double kEncoder_rad = 2 * math::kPi / 4096;
const Quat kBaseOptical{0.5, -0.5, 0.5, -0.5};  // z forward, x to the right, y down

ImuErrors vehicle_imu_errors(bool on) {
  ImuErrors e{0, 0, 0, 0, 0, 0, 0, 0};
  if (on) e = {}, e.vibration_mps2 = 0.3;
  return e;
}
RangeErrors vehicle_range_errors(bool on) {
  RangeErrors e;
  e.max_m = kMostRange_m;
  if (!on) e.noise_m = e.noise_share = 0;
  return e;
}
BaroErrors vehicle_baro_errors(bool on) {
  BaroErrors e;
  if (!on) e.noise_pa = e.walk_pa = e.wash_pa = 0;
  return e;
}
BatteryErrors vehicle_battery_errors(bool on) { return on ? BatteryErrors{} : BatteryErrors{0, 0, 0, 0, 0}; }

}  // namespace

Vehicle::Vehicle(Place& place, std::size_t slot, const VehicleKind& kind, const Start& start, const Options& options)
    : place_(&place),
      slot_(slot),
      kind_(&kind),
      rotors_(kind),
      wheels_(kind),
      battery_s_(kind.battery_s * options.battery_charge),
      imu_(vehicle_imu_errors(options.sensor_errors), options.seed),
      range_(vehicle_range_errors(options.sensor_errors), options.seed),
      baro_(vehicle_baro_errors(options.sensor_errors), options.seed),
      battery_(vehicle_battery_errors(options.sensor_errors), options.seed),
      noise_(options.seed, 0x7668636c),
      errors_(options.sensor_errors) {
  put(start);
}

void Vehicle::put(const Start& start) {
  body_ = {};
  body_.p_world_m = start.p_world_m;
  body_.angles_rad.yaw = start.yaw_rad;
}

void Vehicle::take(RobotCommand command) {
  const auto channel = [&](std::size_t i) { return i < command.size() ? command[i] : 0.0; };
  command_.rotors = {{channel(0), channel(1), channel(2)}, channel(3)};
  for (std::size_t i = 0; i < kCameraJoints; ++i)
    if (4 + i < command.size()) camera_drive_[i] = {false, command[4 + i]};
}

CameraPose Vehicle::camera_pose() const {
  const Quat q_base = body_.q_world_base();
  const Quat q = q_base * Quat::from_axis_angle({0, 0, 1}, camera_.position_rad[kPan]) *
                 Quat::from_axis_angle({0, 1, 0}, camera_.position_rad[kTilt]) * kBaseOptical;
  const Vec3 p = body_.p_world_m + q_base.rotate(kind_->camera_p_base_m);
  return {p.to<msg::Vec3>(), q.to<msg::Quat>(), focal_per_height()};
}

Solid Vehicle::hull() const {
  return {Shape::sphere, body_.p_world_m + Vec3{0, 0, kind_->hull_up_m}, {}, {kind_->hull_radius_m, 0, 0}};
}

WorldTruth Vehicle::ground_truth() const {
  WorldTruth t;
  t.p_world_m = body_.p_world_m.to<msg::Vec3>();
  t.v_world_mps = body_.v_world_mps.to<msg::Vec3>();
  t.q_world_base = body_.q_world_base().to<msg::Quat>();
  t.gyro_radps = body_.gyro_radps().to<msg::Vec3>();
  t.target_world_m = place_->target_m().to<msg::Vec3>();
  t.battery_v = due_.battery_sample.voltage_v;
  t.contact = body_.touches || body_.stands;
  t.landed = body_.stands;
  return t;
}

Scene Vehicle::scene(std::size_t /*camera*/) const {
  Scene scene = place_->bodies(slot_);
  scene.camera = camera_pose();
  return scene;
}

bool Vehicle::still() const { return body_.stands && math::squared_norm(body_.v_world_mps) < 1e-6; }

JointLimits Vehicle::limits(std::size_t joint) const {
  if (joint == kPan) return {-kind_->pan_rad, kind_->pan_rad, kind_->camera_radps, 0};
  return {-kind_->tilt_up_rad, kind_->tilt_down_rad, kind_->camera_radps, 0};
}

JointMotion Vehicle::motion(std::size_t joint) const {
  JointMotion m;
  m.position_rad = camera_.position_rad[joint];
  m.velocity_radps = camera_.rate_radps[joint];
  if (taken_[joint]) m.drive = *taken_[joint];
  return m;
}

CameraDrive Vehicle::camera_drive(std::size_t joint) const {
  if (!taken_[joint]) return camera_drive_[joint];
  switch (taken_[joint]->mode) {
    case DriveMode::position:
    case DriveMode::impedance:
      return {false, taken_[joint]->position_rad};
    case DriveMode::velocity:
      return {true, taken_[joint]->velocity_radps};
    case DriveMode::off:
    case DriveMode::effort:
      break;
  }
  return {true, 0};  // its gear holds it
}

void Vehicle::step_camera(double dt_s) {
  for (std::size_t i = 0; i < kCameraJoints; ++i) {
    const CameraDrive drive = camera_drive(i);
    const JointLimits limit = limits(i);
    double& at = camera_.position_rad[i];
    const double wanted = drive.by_rate ? drive.value : (drive.value - at) / kCameraLag_s;
    const double rate = std::clamp(wanted, -limit.speed_radps, limit.speed_radps);
    const double next = std::clamp(at + dt_s * rate, limit.least_rad, limit.most_rad);
    camera_.rate_radps[i] = (next - at) / dt_s;
    at = next;
  }
}

void Vehicle::step(const Surroundings& around, double dt_s) {
  const Vec3 before = body_.p_world_m;
  if (kind_->locomotion == Locomotion::rotors)
    rotors_.step(body_, command_.rotors, powered(), place_->wind_mps(), around, dt_s);
  else if (kind_->steers())
    wheels_.step(body_,
                 {powered() ? command_.steered.spin_radps : 0, command_.steered.front_rad, command_.steered.rear_rad},
                 around, dt_s);
  else
    wheels_.step(body_, powered() ? command_.left_radps : 0, powered() ? command_.right_radps : 0, around, dt_s);
  driven_m_ += math::norm(body_.p_world_m - before);
  highest_m_ = std::max(highest_m_, body_.p_world_m.z);
  battery_s_ = std::max(0.0, battery_s_ - dt_s);
  step_camera(dt_s);
  if (body_.touches && !touched_) ++touches_;
  touched_ = body_.touches;
  gyro_sum_ += body_.gyro_radps();
  accel_sum_ += body_.q_world_base().conjugate().rotate(body_.accel_world_mps2 + Vec3{0, 0, kGravity});
}

void Vehicle::sample(std::int64_t steps, const Surroundings& around) {
  const msg::Time now{steps * kStepNs};
  const auto every = [&](int period) { return steps % period == 0; };
  due_.imu = every(kImuSteps), due_.range = every(kVehicleRangeSteps), due_.baro = every(kVehicleBaroSteps);
  due_.battery = every(kVehicleBatterySteps), due_.joints = every(kVehicleJointSteps), due_.truth = every(kTruthSteps);
  due_.cameras = now.ns == camera_stamp_ns(next_frame_);
  if (due_.cameras != 0) ++next_frame_;
  const double wash = turns_rotors() ? 0.6 : 0;
  if (due_.imu) {
    constexpr double kShare = 1.0 / kImuSteps;
    due_.imu_sample = imu_.measure((kShare * gyro_sum_).to<msg::Vec3>(), (kShare * accel_sum_).to<msg::Vec3>(), wash,
                                   kImuSteps * kVehicleStep_s);
    due_.imu_sample.stamp = {now.ns - kImuSteps * kStepNs / 2};  // the middle of the interval averaged over
    gyro_sum_ = accel_sum_ = {};
  }
  if (due_.range) {
    const Vec3 down = body_.q_world_base().rotate({0, 0, -1});
    const auto ground = around.beam(body_.p_world_m, down, kMostRange_m);
    due_.range_sample = {now, range_.measure(ground ? ground->range_m : -1)};
  }
  if (due_.baro) {
    due_.baro_sample = baro_.measure(body_.p_world_m.z, wash, kVehicleBaroSteps * kVehicleStep_s);
    due_.baro_sample.stamp = now;
  }
  if (due_.battery) {
    const double charge = battery_s_ / kind_->battery_s, load = turns_rotors() ? 1 : 0.2;
    due_.battery_sample =
        battery_.measure(kind_->battery_empty_v + charge * (kind_->battery_full_v - kind_->battery_empty_v),
                         load * kind_->battery_a, charge);
    due_.battery_sample.stamp = now;
  }
  if (due_.joints) {
    msg::JointState& s = due_.joints_samples[0];
    s = {};
    s.stamp = now;
    s.count = kCameraJoints;
    for (std::size_t i = 0; i < kCameraJoints; ++i) {
      s.measured[i] = now;
      s.position_rad[i] =
          errors_ ? kEncoder_rad * math::round(camera_.position_rad[i] / kEncoder_rad) : camera_.position_rad[i];
      s.velocity_radps[i] = camera_.rate_radps[i] + (errors_ ? 0.01 * noise_.normal() : 0);
      s.temperature_c[i] = 25;
      s.voltage_v[i] = 5;
      s.mode[i] = msg::JointMode::enabled;
      s.ready |= 1u << i;
    }
  }
  if (due_.truth) watch_target(now, kTruthSteps * kVehicleStep_s);
}

// ---- the verdict

void Vehicle::watch_target(msg::Time now, double dt_s) {
  wind_max_mps_ = std::max(wind_max_mps_, math::norm(place_->wind_mps()));
  moved_ = moved_ || math::squared_norm(body_.v_world_mps) > 0.01;
  if (!place_->has_target()) return;
  const CameraPose camera = camera_pose();
  const Vec3 eye(camera.p_world_m), to = place_->target_m() - eye;
  const Vec3 d = Quat(camera.q_world_optical).conjugate().rotate(to);
  const double far = math::norm(to), half_height = 0.5 / camera.focal_per_height, half_width = half_height * 4 / 3;
  const double radius_m = place_->map().target_radius_m;
  const bool inside = d.z > radius_m && math::fabs(d.x) + radius_m < half_width * d.z &&
                      math::fabs(d.y) + radius_m < half_height * d.z;  // all of it
  const double clear_m = far - 1.2 * radius_m;
  const bool hidden = clear_m > 0 && place_->beam(*this, eye, to / far, clear_m).has_value();
  const bool seen = inside && !hidden;
  const Vec3 away = place_->target_m() - body_.p_world_m;
  const double over_m = math::hypot(away.x, away.y);
  if (!found_) over_m_ = over_m;
  const double off = math::atan2(math::hypot(d.x, d.y), d.z);
  if (!found_) {  // it passes through many pictures while a camera is turned round
    middle_s_ = seen && off < kMiddle_rad ? middle_s_ + dt_s : 0;
    found_ = middle_s_ >= kFound_s;
    return;
  }
  over_m_ += (dt_s / kLately_s) * (over_m - over_m_);
  if (reached_.ns == 0 && over_m <= kReached_m) reached_ = now;
  watched_s_ += dt_s;
  in_view_s_ += seen ? dt_s : 0;
  loss_s_ = seen ? 0 : loss_s_ + dt_s;
  longest_loss_s_ = std::max(longest_loss_s_, loss_s_);
  off_axis2_ += off * off * dt_s;
  distance_sum_ += far * dt_s;
}

Verdict Vehicle::verdict() const {
  const bool has_goal = place_->options().has_goal;
  Verdict v;
  v.begun = moved_;
  v.measures = {{"touches", "touched something", "times", static_cast<double>(touches_), 0.0},
                {"driven_m", "way", "m", driven_m_}};
  if (watched_s_ > 0) {
    const auto limit = [&](double value) { return has_goal ? std::optional(value) : std::nullopt; };
    v.measures.push_back({"in_view_share", "target in view", "of the time since it was found", in_view_s_ / watched_s_,
                          limit(kInView), true});
    v.measures.push_back({"longest_loss_s", "longest loss", "s", longest_loss_s_});
    v.measures.push_back({"arrival_error_m", "beside the target at the end", "m", over_m_, limit(kReached_m)});
    if (reached_.ns != 0) v.measures.push_back({"reached_s", "over the target after", "s", msg::seconds(reached_)});
    v.measures.push_back({"off_axis_rms_deg", "target off the camera's axis", "deg RMS",
                          math::sqrt(off_axis2_ / watched_s_) * 180 / math::kPi});
    v.measures.push_back({"target_distance_m", "mean distance to the target", "m", distance_sum_ / watched_s_});
  }
  v.conditions = {{"wind_max_mps", "strongest wind", "m/s", wind_max_mps_}};
  const bool kept = watched_s_ > 0 && in_view_s_ >= kInView * watched_s_;
  v.good = moved_ && touches_ == 0 && (!has_goal || (kept && over_m_ <= kReached_m));
  if (has_goal && watched_s_ == 0)
    v.outcome = "never saw the target";
  else if (has_goal && !kept)
    v.outcome = "lost the target from view";
  else if (has_goal && over_m_ > kReached_m)
    v.outcome = "did not reach the target";
  else if (has_goal && touches_ == 0)
    v.outcome = "kept the target in view and reached it";
  else if (!moved_)
    v.outcome = "did not move";
  else if (touches_ > 0)
    v.outcome = "touched something";
  else
    v.outcome = body_.stands ? "stands" : "in the air";
  return v;
}

std::string Vehicle::outcome() const {
  char text[200];
  const int n = std::snprintf(text, sizeof text, "%s %s at %.2f, %.2f, %.2f m after %.1f m; touched something %u times",
                              kind_->name, body_.stands ? "stands" : "in the air", body_.p_world_m.x, body_.p_world_m.y,
                              body_.p_world_m.z, driven_m_, touches_);
  std::string all(text, static_cast<std::size_t>(std::clamp(n, 0, static_cast<int>(sizeof text) - 1)));
  if (watched_s_ > 0) {
    std::snprintf(text, sizeof text, "; target in view for %.0f %%", 100 * in_view_s_ / watched_s_);
    all += text;
  }
  return all;
}

void Vehicle::add_to(JsonObject& j) const {
  j.text("kind", kind_->name);
  j.boolean("moved", moved_);
  j.boolean("stands", body_.stands);
  j.integer("touches", touches_);
  j.number("driven_m", driven_m_);
  j.number("battery_s", battery_s_);
  if (watched_s_ > 0) {
    j.number("watched_s", watched_s_);
    j.number("in_view_share", in_view_s_ / watched_s_);
    j.number("off_axis_rms_deg", math::sqrt(off_axis2_ / watched_s_) * 180 / math::kPi);
    j.number("target_distance_m", distance_sum_ / watched_s_);
    j.number("longest_loss_s", longest_loss_s_);
    j.number("arrival_error_m", over_m_);
    if (reached_.ns != 0) j.number("reached_s", msg::seconds(reached_));
  }
}

}  // namespace sinew::plant
