#include "sim_hil/plant/wire_devices.hpp"

#include <charconv>
#include <mutex>

#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"
#include "sim_hil/wire/sim_impedance.hpp"
#include "sim_hil/worlds/joints.hpp"

namespace sinew::plant {

/// A joint of the world under a drive: the drive's effort is what moves it.
class WireDevices::Joint final : public sim_hil::SimJoint {
 public:
  Joint(PlantJoints& joints, std::size_t index) : joints_(joints), index_(index) {}
  double position_rad() const override { return joints_.motion(index_).position_rad; }
  double velocity_radps() const override { return joints_.motion(index_).velocity_radps; }
  void set_effort(double nm) override {
    joints_.drive(index_, nm == 0 ? JointDrive{} : JointDrive{.mode = DriveMode::effort, .effort_nm = nm});
  }
  void advance(hal::Duration) override {}  // the world does

 private:
  PlantJoints& joints_;
  std::size_t index_;
};

std::optional<WireServo> parse_wire_servo(const std::string& whole, std::string& why) {
  const auto refuse = [&] {
    std::string types;
    for (const auto& t : wire::mit_motor_types()) types += std::string(types.empty() ? "" : ", ") + t.name;
    std::string models;
    for (const auto& m : wire::servo_models()) models += std::string(models.empty() ? "" : ", ") + std::string(m.name);
    why = "'" + whole +
          "' is none of cia402:ID, cybergear:ID, dronecan:ID, mit:ID:MOTOR (ID 1 to 127; motors: " + types +
          "), MODEL:ID[:LINE] (on a --serial, ID 0 to 252; models: " + models +
          "), with @RAD behind it for a zero that is off by up to 10, and no 'none'";
    return std::nullopt;
  };
  WireServo servo;
  if (whole == "none") {
    servo.protocol = WireServo::Protocol::none;
    return servo;
  }
  const auto at = whole.find('@');
  const std::string text = whole.substr(0, at);
  if (at != std::string::npos) {
    const char* const stop = whole.data() + whole.size();
    const auto [behind, wrong] = std::from_chars(whole.data() + at + 1, stop, servo.zero_rad);
    if (wrong != std::errc() || behind != stop || !(servo.zero_rad >= -10 && servo.zero_rad <= 10)) return refuse();
  }
  const auto colon = text.find(':'), second = text.find(':', colon + 1);
  if (colon == std::string::npos) return refuse();
  const std::string protocol = text.substr(0, colon);
  const char* begin = text.data() + colon + 1;
  const char* end = text.data() + (second == std::string::npos ? text.size() : second);
  const auto [rest, error] = std::from_chars(begin, end, servo.id);
  if (error != std::errc() || rest != end) return refuse();
  if (const wire::ServoModel* model = wire::servo_model(protocol)) {
    servo.protocol = WireServo::Protocol::serial;
    servo.model = model;
    if (servo.id > wire::kDxlMostId2) return refuse();
    if (second == std::string::npos) return servo;
    std::size_t line = 0;
    const char* const stop = text.data() + text.size();
    const auto [behind, wrong] = std::from_chars(text.data() + second + 1, stop, line);
    if (wrong != std::errc() || behind != stop || line < 1 || line > 64) return refuse();
    servo.line = line - 1;
    return servo;
  }
  if (servo.id < 1 || servo.id > 127) return refuse();
  if (second != std::string::npos) servo.motor = text.substr(second + 1);
  if (protocol == "mit" && wire::mit_motor_type(servo.motor)) {
    servo.protocol = WireServo::Protocol::mit;
    return servo;
  }
  if (second != std::string::npos) return refuse();
  if (protocol == "cia402") return servo;
  if (protocol != "cybergear" && protocol != "dronecan") return refuse();
  servo.protocol = protocol == "dronecan" ? WireServo::Protocol::dronecan : WireServo::Protocol::cybergear;
  return servo;
}

bool plays(FaultKind kind) { return kind == FaultKind::off || kind == FaultKind::stuck || kind == FaultKind::garbage; }

WireDevices::WireDevices() = default;
WireDevices::~WireDevices() = default;

void WireDevices::add_servos(std::unique_ptr<hal::CanBus> bus, std::vector<WireServo> servos) {
  bus_ = std::move(bus);
  servos_ = std::move(servos);
}

void WireDevices::add_faults(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) faults_.push_back({fault, 0});
}

void WireDevices::play_faults(hal::Time plant_now) {
  bool off = false, stuck = false, garbage = false;
  for (FaultLog::Entry& entry : faults_) {
    if (!entry.fault.acts_at(plant_now)) continue;
    if (entry.affected == 0) entry.strike(plant_now, drives_.size());
    if (entry.fault.kind == FaultKind::off)
      off = true;
    else if (entry.fault.kind == FaultKind::stuck)
      stuck = true;
    else
      garbage = true;
  }
  std::vector<std::unique_lock<std::mutex>> still;  // the lines' threads meanwhile
  for (const auto& line : lines_) still.emplace_back(line->mutex());
  for (sim_hil::SimDrive* drive : drives_) {
    drive->power(!off);
    drive->faults.stuck = stuck, drive->faults.garbage = garbage;
  }
}

hal::Status WireDevices::attach(World& world) {
  for (const auto& line : lines_) line->clear();
  joints_.clear();
  drives_.clear();
  sims_.reset();
  if (servos_.empty()) return {};
  PlantJoints* joints = world.robot(0).joints();
  if (!joints || joints->count() < servos_.size())
    return hal::Error{hal::Errc::bad_argument, "more drives than the world has joints",
                      static_cast<std::int64_t>(servos_.size())};
  if (bus_) sims_ = std::make_unique<sim_hil::SimServos>(*bus_);
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if (!servos_[i].has_drive()) continue;
    if (const WireServo& s = servos_[i]; s.on_line()) {
      drives_.push_back(&lines_.at(s.line)->add(*joints, i, *s.model, s.id, s.zero_rad));
      continue;
    }
    Joint& joint = *joints_.emplace_back(std::make_unique<Joint>(*joints, i));
    const WireServo& s = servos_[i];
    const sim_hil::SimMount mount{.zero_rad = s.zero_rad};
    joint.set_effort(0);
    switch (s.protocol) {
      case WireServo::Protocol::cia402: {
        sim_hil::SimCia402::Parameters p;
        p.node_id = s.id;
        p.rated_nm = joints->limits(i).effort_nm;
        // A joint of some 0.01 kg m^2, held at 25/s without ringing.
        p.kp = 8, p.kd = 0.5;
        drives_.push_back(&sims_->add<sim_hil::SimCia402>(joint, mount, p));
        break;
      }
      case WireServo::Protocol::mit: {
        sim_hil::SimMitMotor::Parameters p;
        p.motor = s.id;
        p.type = *wire::mit_motor_type(s.motor);
        drives_.push_back(&sims_->add<sim_hil::SimMitMotor>(joint, mount, p));
        break;
      }
      case WireServo::Protocol::dronecan: {
        sim_hil::SimDronecanServo::Parameters p;
        p.node_id = static_cast<std::uint8_t>(s.id);
        p.actuator_id = static_cast<std::uint8_t>(i);
        p.most_nm = joints->limits(i).effort_nm;
        p.kp = 8, p.kd = 0.5;  // as above
        drives_.push_back(&sims_->add<sim_hil::SimDronecanServo>(joint, mount, p));
        break;
      }
      case WireServo::Protocol::cybergear:
        drives_.push_back(
            &sims_->add<sim_hil::SimCyberGear>(joint, mount, sim_hil::SimCyberGear::Parameters{.motor = s.id}));
        break;
      case WireServo::Protocol::serial:
      case WireServo::Protocol::none:
        break;
    }
  }
  for (const auto& line : lines_)
    if (hal::Status started = line->start(); !started) return started;
  return {};
}

void WireDevices::step(const World& world, const Due& due, hal::Time now) {
  if (!drives_.empty() && !faults_.empty()) play_faults(world.now());
  if (sims_) sims_->poll(now);
  for (const auto& line : lines_) line->step(world.now());
  const bool plugged = world.now() < out_from_ || world.now() >= out_until_;
  if (camera_ && plugged != plugged_) camera_->set_plugged(plugged_ = plugged);
  if (imu_ && due.imu && imu_->enabled()) {
    msg::ImuSample sample = due.imu_sample;
    sample.gyro_radps = {sample.gyro_radps.x + gyro_bias_radps_.x, sample.gyro_radps.y + gyro_bias_radps_.y,
                         sample.gyro_radps.z + gyro_bias_radps_.z};
    sample.stamp = now - (world.now() - sample.stamp);
    static_cast<void>(imu_->feed(sample));  // full: nobody reads, as in the kernel
  }
}

}  // namespace sinew::plant
