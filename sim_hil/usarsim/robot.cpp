#include "sim_hil/usarsim/robot.hpp"

#include <algorithm>

#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim {

using math::Quat;
using math::Vec3;
using plant::Locomotion;
using wire::UsarWriter;

namespace {

constexpr double kInsDrift = 0.001;                     // DefaultUSAR.ini, [USARSensor.INS] Precision: of the way
constexpr double kEncoderNoise = 0.005;                 // [USARSensor.Encoder] Noise
constexpr double kGpsLeast_m = 0.75, kGpsMost_m = 2.5;  // [USARBot.GPSSensor]: with 12, with 4 satellites
constexpr std::size_t kGpsNeeds = 4;
constexpr double kMetresPerMinute = 1852;  // of latitude

std::array<double, 3> list(const Vec3& v) { return {v.x, v.y, v.z}; }

/// "47,40.3323,N": whole degrees, minutes, and the side.
std::string degrees_and_minutes(double deg, char positive, char negative) {
  const double all = math::fabs(deg), whole = math::floor(all);
  std::array<char, 32> text{};
  const std::size_t n = wire::write_fixed((all - whole) * 60, 4, text);
  return std::to_string(static_cast<int>(whole)) + "," + std::string(text.data(), n) + "," +
         (deg < 0 ? negative : positive);
}

}  // namespace

Robot::Robot(Game& game, const Game::Bot& bot, std::uint64_t seed) : game_(game), bot_(bot), random_(seed, 0x75736172) {
  const double now_s = game_.now_s();
  const auto sensors = bot_.kind->sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto same = std::ranges::find_if(due_, [&](const Due& d) {
      return sensors[d.sensors[0]].type == sensors[i].type && d.interval_s == sensors[i].interval_s;
    });
    if (same != due_.end())
      same->sensors.push_back(i);
    else
      due_.push_back({What::sensors, {i}, sensors[i].interval_s, now_s + sensors[i].interval_s});
  }
  due_.push_back({What::package, {}, kStatusInterval_s, now_s + kStatusInterval_s});
  due_.push_back({What::status, {}, kStatusInterval_s, now_s + kStatusInterval_s});
  const plant::BodyState& body = vehicle().body();
  visit_.name = bot_.name, visit_.kind = bot_.kind;
  visit_.from_s = now_s, visit_.from_m = body.p_world_m;
  start_z_m_ = body.p_world_m.z;
  ins_.last_m = ins_.position_m = body.p_world_m;
  ins_.last_rad = ins_.angles_rad = Frame::angles(body.angles_rad);
  for (int i = 0; i < 3; ++i) ins_.share[i] = kInsDrift * (random_.uniform() - 0.5);
}

Game::Visit Robot::visit() const {
  const plant::Vehicle& v = vehicle();
  Game::Visit visit = visit_;
  visit.until_s = game_.now_s();
  visit.to_m = v.body().p_world_m;
  visit.driven_m = v.driven_m(), visit.highest_m = v.highest_m(), visit.touches = v.touches();
  visit.stands = v.body().stands;
  visit.verdict = v.verdict();
  return visit;
}

// ---- what is due

bool Robot::in_one_line(const Due& due) const {
  const SensorType type = mount(due.sensors[0]).type;
  return type == SensorType::encoder || (type == SensorType::sonar && game_.options().sonars_together);
}

void Robot::write_status(UsarWriter& out) const {
  const plant::Vehicle& v = vehicle();
  const bool flies = v.kind().locomotion == Locomotion::rotors;
  out.type("STA").text("Type", flies ? "AerialVehicle" : "GroundVehicle").number("Time", game_.now_s(), 2);
  if (!flies)  // clockwise
    out.number("FrontSteer", 0 - v.wheels().front_steer_rad()).number("RearSteer", 0 - v.wheels().rear_steer_rad());
  out.flag("LightToggle", light_).integer("LightIntensity", light_ ? 100 : 0);
  out.integer("Battery", static_cast<std::int64_t>(v.battery_s())).integer("View", game_.view_of(bot_.slot));
}

/// Link 1 is the pan, positive clockwise; link 2 the tilt, positive upwards: as yaw and pitch are counted.
void Robot::write_package(UsarWriter& out, const char* type) const {
  out.type(type).number("Time", game_.now_s(), 2).text("Name", kPackageName);
  const bool with_torque = std::string_view(type) == "MISSTA";
  for (std::size_t i = 0; i < plant::kCameraJoints; ++i) {
    out.integer("Link", static_cast<std::int64_t>(i + 1)).number("Value", 0 - vehicle().camera().position_rad[i]);
    if (with_torque) out.number("Torque", kPackageTorque, 2);
  }
}

void Robot::sense(std::span<const std::size_t> sensors, UsarWriter& out) {
  const SensorMount& m = mount(sensors[0]);
  out.type("SEN");
  if (m.stamped) out.number("Time", game_.now_s(), 4);
  out.text("Type", to_string(m.type));
  switch (m.type) {
    case SensorType::ground_truth:
      return sense_truth(m, out);
    case SensorType::gps:
      return sense_gps(m, out);
    case SensorType::ins:
      return sense_ins(m, out);
    case SensorType::imu:
      return sense_imu(m, out);
    case SensorType::acceleration:
      return sense_acceleration(m, out);
    case SensorType::range_scanner:
      return sense_scanner(m, out);
    case SensorType::odometry:
      return sense_odometry(m, out);
    case SensorType::altitude:
      return sense_altitude(m, out);
    case SensorType::touch:
      out.text("Name", m.name).flag("Touch", touches(m));
      return;
    case SensorType::encoder:
      for (const std::size_t i : sensors) out.text("Name", mount(i).name).integer("Tick", ticks(mount(i)));
      return;
    case SensorType::sonar:
      break;
  }
  if (!game_.options().sonars_together) {
    out.text("Name", m.name).number("Range", sonar_m(m));
    return;
  }
  out.open();
  for (const std::size_t i : sensors) out.word("Name").word(mount(i).name).word("Range").word(sonar_m(mount(i)), 4);
  out.close();
}

// ---- sensors

void Robot::sense_truth(const SensorMount& m, UsarWriter& out) const {
  const plant::BodyState& body = vehicle().body();
  out.text("Name", m.name)
      .vector("Location", list(game_.options().frame.turned(body.p_world_m)), m.decimals)
      .vector("Orientation", list(positive_turns(Frame::angles(body.angles_rad))), m.decimals);
}

void Robot::sense_ins(const SensorMount& m, UsarWriter& out) {
  const plant::BodyState& body = vehicle().body();
  const Vec3 angles = Frame::angles(body.angles_rad), way = body.p_world_m - ins_.last_m;
  ins_.position_m += way + math::norm(way) * ins_.share;
  for (int i = 0; i < 3; ++i) ins_.angles_rad[i] += math::wrap_pi(angles[i] - ins_.last_rad[i]);
  ins_.last_m = body.p_world_m;
  ins_.last_rad = angles;
  out.text("Name", m.name)
      .vector("Location", list(game_.options().frame.turned(ins_.position_m)), m.decimals)
      .vector("Orientation", list(positive_turns(ins_.angles_rad)), m.decimals);
}

Vec3 Robot::acceleration() const {
  const plant::BodyState& body = vehicle().body();
  return game_.options().frame.turned(body.q_world_base().conjugate().rotate(body.accel_world_mps2));
}

void Robot::sense_imu(const SensorMount& m, UsarWriter& out) {
  const plant::BodyState& body = vehicle().body();
  const Vec3 rates = Frame::angles(body.rates_radps);
  const double now_s = game_.now_s(), passed_s = now_s - last_imu_s_;
  const Vec3 rate_change = last_imu_s_ >= 0 && passed_s > 0 ? (rates - last_rates_) / passed_s : Vec3{};
  last_rates_ = rates;
  last_imu_s_ = now_s;
  out.text("Name", m.name)
      .vector("XYZAcceleration", list(acceleration()))
      .vector("AngularVel", list(rates))
      .vector("AngularAccel", list(rate_change))
      .vector("Rotation", list(Frame::angles(body.angles_rad)));
}

void Robot::sense_acceleration(const SensorMount& m, UsarWriter& out) const {
  out.text("Name", m.name).vector("Acceleration", list(acceleration()));
}

std::optional<double> Robot::beam_m(const SensorMount& m, const Vec3& direction, double* incidence_rad) const {
  const plant::BodyState& body = vehicle().body();
  const Quat q = body.q_world_base();
  const Vec3 along = q.rotate(direction);
  const auto hit = game_.place().beam(vehicle(), body.p_world_m + q.rotate(m.p_base_m), along, m.most_m);
  if (!hit) return std::nullopt;
  if (incidence_rad) *incidence_rad = math::acos(std::clamp(-dot(hit->normal, along), -1.0, 1.0));
  return hit->range_m;
}

/// The nearest echo in a cone: the axis always answers, the rest of it only from surfaces that it meets squarely.
/// Source:  SonarSensor.uc, GetData.
double Robot::sonar_m(const SensorMount& m) const {
  const Quat q = Quat::from_axis_angle({0, 0, 1}, m.yaw_rad) * Quat::from_axis_angle({0, 1, 0}, m.pitch_rad);
  double range = beam_m(m, q.rotate({1, 0, 0}), nullptr).value_or(m.most_m);
  for (int cone = 1; cone <= kCones; ++cone) {
    const math::SinCos off = math::sincos(cone * kBeamAngle_rad / 2 / kCones);
    for (int trace = 0; trace < kTracesPerCone; ++trace) {
      const math::SinCos round = math::sincos(2 * math::kPi * trace / kTracesPerCone);
      double incidence = 0;
      const auto echo = beam_m(m, q.rotate({off.cos, off.sin * round.cos, off.sin * round.sin}), &incidence);
      if (echo && incidence <= kMostIncidence_rad) range = std::min(range, *echo);
    }
  }
  return std::clamp(range, kSonarLeast_m, m.most_m);
}

/// Source: RangeScanner.uc: from the right to the left, two decimals.
void Robot::sense_scanner(const SensorMount& m, UsarWriter& out) const {
  std::array<double, 512> ranges;
  const auto count = std::min(ranges.size(), static_cast<std::size_t>(m.fov_rad / m.resolution_rad + 1e-6) + 1);
  for (std::size_t i = 0; i < count; ++i) {
    const math::SinCos a = math::sincos(m.yaw_rad - m.fov_rad / 2 + static_cast<double>(i) * m.resolution_rad);
    ranges[i] = std::clamp(beam_m(m, {a.cos, a.sin, 0}, nullptr).value_or(m.most_m), kScannerLeast_m, m.most_m);
  }
  out.text("Name", m.name).number("Resolution", m.resolution_rad).number("FOV", m.fov_rad);
  out.vector("Range", {ranges.data(), count}, 2);
}

/// Source: Odometry.uc: theta clockwise, y to the right. Of steered wheels it is the way of the axle that does not
/// steer.
void Robot::sense_odometry(const SensorMount& m, UsarWriter& out) {
  const plant::WheelMotion& wheels = vehicle().wheels();
  const plant::VehicleKind& kind = vehicle().kind();
  const double left = kind.wheel_radius_m * (wheels.left_rad() - odometer_.left_rad),
               right = kind.wheel_radius_m * (wheels.right_rad() - odometer_.right_rad);
  odometer_.left_rad = wheels.left_rad(), odometer_.right_rad = wheels.right_rad();
  const double turn = (left - right) / kind.track_m;
  const math::SinCos a = math::sincos(odometer_.theta_rad + turn / 2);
  odometer_.x_m += a.cos * (left + right) / 2;
  odometer_.y_m += a.sin * (left + right) / 2;
  odometer_.theta_rad = math::wrap_pi(odometer_.theta_rad + turn);
  out.text("Name", m.name).vector("Pose", list({odometer_.x_m, odometer_.y_m, odometer_.theta_rad}));
}

std::int64_t Robot::ticks(const SensorMount& m) {
  const plant::WheelMotion& wheels = vehicle().wheels();
  const double turned =
      (m.left ? wheels.left_rad() : wheels.right_rad()) * (1 + random_.uniform(-kEncoderNoise, kEncoderNoise));
  return static_cast<std::int64_t>(turned / m.resolution_rad);
}

bool Robot::touches(const SensorMount& m) const {
  SensorMount feeler = m;
  feeler.most_m = kTouch_m;
  const math::SinCos a = math::sincos(m.yaw_rad);
  return vehicle().body().touches || beam_m(feeler, {a.cos, a.sin, 0}, nullptr).has_value();
}

void Robot::sense_gps(const SensorMount& m, UsarWriter& out) {
  const Vec3& p = vehicle().body().p_world_m;
  const plant::PlaceMap& map = game_.place().map();
  const std::size_t satellites = game_.place().satellites(p);
  out.text("Name", m.name);
  if (satellites < kGpsNeeds) {
    out.integer("Fix", 0).integer("Satellites", static_cast<std::int64_t>(satellites));
    return;
  }
  const double share = static_cast<double>(satellites - kGpsNeeds) / (plant::Place::kSatellites - kGpsNeeds);
  const double most_m = kGpsMost_m + share * (kGpsLeast_m - kGpsMost_m);
  const auto error = [&] { return most_m * std::clamp(random_.normal() / 3, -1.0, 1.0); };
  const double latitude = map.latitude_deg + (p.y + error()) / kMetresPerMinute / 60;
  const double longitude =
      map.longitude_deg + (p.x + error()) / kMetresPerMinute / 60 / math::cos(map.latitude_deg * math::kPi / 180);
  out.text("Latitude", degrees_and_minutes(latitude, 'N', 'S'))
      .text("Longitude", degrees_and_minutes(longitude, 'E', 'W'))
      .integer("Fix", 1)
      .integer("Satellites", static_cast<std::int64_t>(satellites));
}

void Robot::sense_altitude(const SensorMount& m, UsarWriter& out) const {
  const double z = vehicle().body().p_world_m.z;
  out.text("Name", m.name)
      .number("relativeAltitude", z - start_z_m_)
      .number("absoluteAltitude", std::max(0.0, kSeaLevel_m + z - start_z_m_));
}

// ---- answers

bool Robot::has(std::string_view type, std::string_view name, std::vector<std::size_t>& found) const {
  bool known = false;
  for (std::size_t i = 0; i < bot_.kind->sensors.size(); ++i) {
    if (!same_word(to_string(mount(i).type), type)) continue;
    known = true;
    if (name.empty() || same_word(name, mount(i).name)) found.push_back(i);
  }
  return known;
}

bool Robot::configuration(std::string_view type, std::string_view name, UsarWriter& out) const {
  const plant::VehicleKind& k = vehicle().kind();
  const bool flies = k.locomotion == Locomotion::rotors;
  out.type("CONF");
  if (same_word(type, "Robot")) {
    out.text("Type", flies ? "AerialVehicle" : "GroundVehicle").text("Name", bot_.kind->name);
    out.text("SteeringType", flies        ? "AirRobot"
                             : k.steers() ? "AckermanSteered"
                                          : "SkidSteered")
        .number("Mass", k.mass_kg);
    if (flies)
      out.number("MaxSpeed", k.speed_mps).number("MaxAltitudeSpeed", k.climb_mps).number("MaxTurn", k.turn_radps);
    else
      out.number("MaxSpeed", k.wheel_radps)
          .number("MaxTorque", 40)
          .number("MaxFrontSteer", k.front_steer_rad)
          .number("MaxRearSteer", k.rear_steer_rad);
    return true;
  }
  const bool package = same_word(type, "MisPkg"), actuator = same_word(type, "Actuator");
  if (package || actuator) {
    out.text("Type", package ? "MisPkg" : "Actuator").text("Name", kPackageName);
    const double least[] = {-k.pan_rad, -k.tilt_down_rad}, most[] = {k.pan_rad, k.tilt_up_rad};
    for (std::size_t i = 0; i < plant::kCameraJoints; ++i) {
      out.integer("Link", static_cast<std::int64_t>(i + 1)).text("JointType", "Revolute");
      if (package) out.number("MaxRotationSpeed", k.camera_radps);
      out.number("MaxTorque", -kPackageTorque, 2);
      out.number(package ? "MinRange" : "MinValue", least[i]).number(package ? "MaxRange" : "MaxValue", most[i]);
    }
    return true;
  }
  if (same_word(type, "Camera")) {
    const double across =
        2 * math::atan(0.5 / vehicle().focal_per_height() * game_.options().tile_width / game_.options().tile_height);
    out.text("Type", "Camera").text("Name", kCameraName).number("CameraDefFov", 1.3963).number("CameraMinFov", 0.3491);
    out.number("CameraMaxFov", 2.0944).number("CameraFov", across);
    return true;
  }
  std::vector<std::size_t> found;
  out.text("Type", clean(type));
  const bool known = has(type, name, found);
  for (const std::size_t i : found) {
    const SensorMount& m = mount(i);
    out.text("Name", m.name).number("ScanInterval", m.interval_s);
    if (m.type == SensorType::sonar)
      out.number("MaxRange", m.most_m)
          .number("MinRange", kSonarLeast_m)
          .number("beamAngle", kBeamAngle_rad)
          .number("maxAngleOfIncidence", kMostIncidence_rad)
          .integer("tracesPerCone", kTracesPerCone)
          .integer("numberOfCones", kCones);
    if (m.type == SensorType::range_scanner)
      out.number("MaxRange", m.most_m)
          .number("MinRange", kScannerLeast_m)
          .number("Resolution", m.resolution_rad)
          .number("Fov", m.fov_rad)
          .flag("Panning", false)
          .flag("Tilting", false);
    if (m.type == SensorType::encoder) out.number("Resolution", m.resolution_rad);
    if (m.type == SensorType::touch) out.number("Diameter", 0.01);
  }
  return known;
}

bool Robot::geometry(std::string_view type, std::string_view name, UsarWriter& out) const {
  const plant::VehicleKind& k = vehicle().kind();
  const Frame& frame = game_.options().frame;
  const bool flies = k.locomotion == Locomotion::rotors;
  out.type("GEO");
  if (same_word(type, "Robot")) {
    out.text("Type", flies ? "AerialVehicle" : "GroundVehicle").text("Name", bot_.kind->name);
    out.vector("Dimensions", list(k.size_m)).vector("COG", list({}));
    if (!flies)
      out.number("WheelRadius", k.wheel_radius_m)
          .number("WheelSeparation", k.track_m)
          .number("WheelBase", k.wheelbase_m);
    return true;
  }
  const auto place = [&](const char* what, const Vec3& p, const Vec3& rpy, const char* mounted) {
    out.text("Name", what).vector("Location", list(frame.turned(p))).vector("Orientation", list(rpy));
    out.text("Mount", mounted);
  };
  const bool package = same_word(type, "MisPkg"), actuator = same_word(type, "Actuator");
  if (package || actuator) {
    out.text("Type", package ? "MisPkg" : "Actuator");
    place(kPackageName, k.camera_p_base_m, {}, bot_.kind->name);
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(plant::kCameraJoints); ++i)
      out.integer("Link", i + 1)
          .integer(package ? "ParentLink" : "Parent", i)
          .vector("Location", list({}))
          .vector("Orientation", list({}));
    return true;
  }
  if (same_word(type, "Camera")) {
    out.text("Type", "Camera");
    place(kCameraName, {}, {}, kPackageName);
    out.integer("MountLink", static_cast<std::int64_t>(plant::kCameraJoints));
    return true;
  }
  std::vector<std::size_t> found;
  out.text("Type", clean(type));
  const bool known = has(type, name, found);
  for (const std::size_t i : found) {
    const SensorMount& m = mount(i);
    place(m.name, m.p_base_m, Frame::angles(math::YawPitchRoll{m.yaw_rad, m.pitch_rad, 0}), bot_.kind->name);
  }
  return known;
}

}  // namespace sinew::usarsim
