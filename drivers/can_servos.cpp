#include "drivers/can_servos.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "drivers/cia402_servo.hpp"
#include "drivers/cybergear_servo.hpp"
#include "drivers/device_board.hpp"
#include "drivers/dronecan_servo.hpp"
#include "drivers/joint_words.hpp"
#include "drivers/mit_servo.hpp"
#include "drivers/servo_group.hpp"

namespace sinew::drivers {
namespace {

constexpr double kMostRad = 1e6, kMostNm = 1e5, kMostRadps = 1e5;

hal::Duration from_ms(double ms) { return hal::Duration{static_cast<std::int64_t>(ms * 1e6)}; }

ServoConfig read_config(DeviceKeys& keys) {
  ServoConfig c;
  c.name = keys.spec().name;
  if (!keys.has("id")) keys.problem("id", "the servo's number on its bus; it is required");
  keys.read_integer("id", c.node_id, 0, 127);
  keys.read_choice<ServoMode>(
      "mode", c.mode,
      {{"position", ServoMode::position}, {"velocity", ServoMode::velocity}, {"effort", ServoMode::effort}});
  keys.read_choice<StopAction>("on_stop", c.stop,
                               {{"torque_off", StopAction::torque_off},
                                {"damp", StopAction::damp},
                                {"hold", StopAction::hold},
                                {"quick_stop", StopAction::quick_stop}});
  keys.read("zero_rad", c.zero_rad, -kMostRad, kMostRad);
  bool reversed = false;
  if (keys.read("reversed", reversed) && reversed) c.sign = -1;
  keys.read("gear_ratio", c.gear_ratio, 1e-3, 1e4);
  keys.read("counts_per_turn", c.counts_per_turn, 0, 1e9);
  keys.read("rated_effort_nm", c.rated_effort_nm, 0, kMostNm);
  keys.read("kp", c.kp, 0, kMostNm);
  keys.read("kd", c.kd, 0, kMostNm);
  keys.read("damp_kd", c.damp_kd, 0, kMostNm);
  keys.read("min_rad", c.limits.position_min_rad, -kMostRad, kMostRad);
  keys.read("max_rad", c.limits.position_max_rad, -kMostRad, kMostRad);
  if (c.limits.position_min_rad >= c.limits.position_max_rad) keys.problem("max_rad", "a number above min_rad");
  keys.read("max_velocity_radps", c.limits.velocity_radps, 1e-6, kMostRadps);
  keys.read("max_effort_nm", c.limits.effort_nm, 1e-6, kMostNm);
  keys.read("derate_start_c", c.derating.start_c, -50, 300);
  keys.read("derate_end_c", c.derating.end_c, -50, 300);
  double ms = 50;
  if (keys.read("feedback_timeout_ms", ms, 1, 10'000)) c.feedback_timeout = from_ms(ms);
  if (keys.read("device_timeout_ms", ms, 0, 10'000)) c.device_timeout = from_ms(ms);
  keys.read("following_error_rad", c.following.position_rad, 0, kMostRad);
  if (keys.read("following_time_ms", ms, 1, 60'000)) c.following.time = from_ms(ms);
  keys.read("plausible_velocity_radps", c.plausible_velocity_radps, 0, kMostRadps);
  keys.read_integer("homing_method", c.homing_method, -128, 127);
  keys.read("needs_disarm", c.needs_disarm);
  return c;
}

void refuse(DeviceKeys& keys, const std::string& wrong) {
  if (!wrong.empty()) keys.problems().push_back({keys.spec().line, keys.path(), '"' + keys.spec().driver + '"', wrong});
}

Duration tick_of(const CanBusConfig& bus) { return from_ms(1e3 / bus.hub.tick_hz); }

void read_cia402(DeviceKeys& keys, JointConfig& joint, const CanBusConfig& bus) {
  Cia402Options o;
  o.tick_hz = bus.hub.tick_hz;
  o.master_node = bus.master_node;
  keys.read_integer("slow_every", o.slow_every, 1, 240);
  keys.read("velocity_unit_radps", o.velocity_unit_radps, 0, kMostRadps);
  keys.read_integer("temperature_index", o.temperature_object.index, 0x2000, 0x9FFF);
  keys.read_integer("temperature_sub", o.temperature_object.sub, 0, 254);
  keys.read("temperature_unit_c", o.temperature_unit_c, 1e-6, 1e3);
  refuse(keys, check_cia402(joint.servo, o));
  refuse(keys, check_times(joint.servo, tick_of(bus), std::max(tick_of(bus), bus.master_heartbeat)));
  joint.make = [config = joint.servo, o](BusPlace& on) -> std::unique_ptr<ServoProtocol> {
    if (!on.has_canopen_master)
      on.add(
          std::make_unique<CanopenMaster>(CanopenMaster::Options{on.config.master_node, on.config.master_heartbeat}));
    on.has_canopen_master = true;
    return std::make_unique<Cia402Servo>(config, o);
  };
}

void read_mit(DeviceKeys& keys, JointConfig& joint, const CanBusConfig& bus) {
  std::string names, name;
  for (const wire::MitMotorType& t : wire::mit_motor_types()) names += std::string(t.name) + ", ";
  keys.require("motor", name, "the type of the motor: " + names + "or \"custom\" with its ranges");
  MitOptions o;
  if (const wire::MitMotorType* known = wire::mit_motor_type(name))
    o.type = *known;
  else if (!name.empty() && name != "custom")
    keys.problem("motor", names + "or \"custom\" with its ranges");
  // The ranges can be changed in most motors.
  keys.read("range_position_rad", o.type.position_rad, 1e-3, 1e4);
  keys.read("range_velocity_radps", o.type.velocity_radps, 1e-3, 1e4);
  keys.read("range_effort_nm", o.type.effort_nm, 1e-3, 1e4);
  keys.read("range_kp", o.type.kp, 1e-3, 1e5);
  keys.read("range_kd", o.type.kd, 1e-3, 1e4);
  keys.read_integer("master_id", o.master_id, 0, 0x7FF);
  refuse(keys, check_mit(joint.servo, o));
  refuse(keys, check_times(joint.servo, tick_of(bus), tick_of(bus)));
  joint.make = [config = joint.servo, o](BusPlace&) -> std::unique_ptr<ServoProtocol> {
    return std::make_unique<MitServo>(config, o);
  };
}

void read_cybergear(DeviceKeys& keys, JointConfig& joint, const CanBusConfig& bus) {
  std::uint32_t host = 0xFD;
  keys.read_integer("host_id", host, 0, 0xFF);
  refuse(keys, check_cybergear(joint.servo, host));
  refuse(keys, check_times(joint.servo, tick_of(bus), tick_of(bus)));
  joint.make = [config = joint.servo, host](BusPlace&) -> std::unique_ptr<ServoProtocol> {
    return std::make_unique<CyberGearServo>(config, host);
  };
}

/// 32 hexadecimal digits; nothing: there are none, or a problem was told.
std::optional<wire::DronecanUniqueId> read_unique_id(DeviceKeys& keys) {
  constexpr const char* kAllowed = "32 hexadecimal digits: who asks for a node id with these gets `id`";
  std::string text;
  if (!keys.read("unique_id", text, kAllowed)) return std::nullopt;
  wire::DronecanUniqueId id{};
  bool good = text.size() == 2 * id.size();
  for (std::size_t i = 0; good && i < id.size(); ++i) {
    const char* begin = text.data() + 2 * i;
    const auto [end, error] = std::from_chars(begin, begin + 2, id[i], 16);
    good = error == std::errc() && end == begin + 2;
  }
  if (good) return id;
  keys.problem("unique_id", kAllowed);
  return std::nullopt;
}

void read_dronecan(DeviceKeys& keys, JointConfig& joint) {
  DronecanServoOptions o;
  keys.read("esc", o.esc);
  keys.read("esc_full_radps", o.esc_full_radps, 0, kMostRadps);
  keys.read("status_hz", o.status_hz, 0.1, 2000);
  if (!keys.has("actuator_id")) keys.problem("actuator_id", "its place in the commands; it is required");
  keys.read_integer("actuator_id", joint.servo.actuator_id, 0, 255);
  const auto unique_id = read_unique_id(keys);
  refuse(keys, check_dronecan(joint.servo, o));
  refuse(keys, check_times(joint.servo, from_ms(1e3 / o.status_hz), Duration{0}));
  joint.make = [config = joint.servo, o, unique_id](BusPlace& on) -> std::unique_ptr<ServoProtocol> {
    if (!on.dronecan) {
      auto node = std::make_unique<DronecanNode>(on.config.dronecan);
      on.dronecan = node.get();
      on.add(std::move(node));
    }
    if (unique_id) on.dronecan->allocate(*unique_id, static_cast<std::uint8_t>(config.node_id));
    return std::make_unique<DronecanServo>(config, o, *on.dronecan);
  };
}

/// The group as its board holds it: which joint each complaint is about, by name, protocol, number and bus.
class JointsReport final : public hal::SelfReport {
 public:
  explicit JointsReport(std::shared_ptr<ServoGroup> group) : group_(std::move(group)) {}
  void add(const JointConfig& joint, const CanHub& hub) {
    joints_.push_back({group_->name() + "." + joint.servo.name + " (" + joint.protocol + " " +
                           std::to_string(joint.servo.node_id) + " on " + joint.bus + ")",
                       &hub});
  }
  std::string trouble() const override {
    std::string all;
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      ServoFeedback said;
      if (!group_->feedback_of(i, said)) continue;  // the next look
      // For a second nobody is missed: the bus has just been started, and drives answer one after the other.
      const bool awaited = said.mode == msg::JointMode::absent && said.measured.ns == 0;
      if (awaited && static_cast<double>(joints_[i].hub->stats().ticks) < joints_[i].hub->config().tick_hz) continue;
      if (const std::string words = joint_words(said); !words.empty()) all += joints_[i].title + ": " + words + "\n";
    }
    return all;
  }

 private:
  struct Joint {
    std::string title;
    const CanHub* hub;
  };
  std::shared_ptr<ServoGroup> group_;
  std::vector<Joint> joints_;
};

}  // namespace

JointConfig read_joint(DeviceKeys& keys, const DeviceSpecs& specs) {
  JointConfig joint;
  joint.protocol = keys.spec().driver;
  std::string buses;
  for (const DeviceSpec& b : specs.buses) buses += (buses.empty() ? "" : ", ") + b.name;
  keys.require("bus", joint.bus, "the name of a [bus.NAME]: " + (buses.empty() ? "there is none" : buses));
  joint.servo = read_config(keys);
  const auto bus =
      std::find_if(specs.buses.begin(), specs.buses.end(), [&](const DeviceSpec& b) { return b.name == joint.bus; });
  CanBusConfig on;
  if (bus != specs.buses.end()) {
    std::vector<rt::Problem> told;  // of the bus's own table
    DeviceKeys bus_keys(*bus, "", told);
    on = read_can_bus(bus_keys);
  } else if (!joint.bus.empty()) {
    keys.problem("bus", "the name of a [bus.NAME]: " + (buses.empty() ? "there is none" : buses));
  }
  const std::string& protocol = keys.spec().driver;
  if (protocol == "cia402")
    read_cia402(keys, joint, on);
  else if (protocol == "mit")
    read_mit(keys, joint, on);
  else if (protocol == "cybergear")
    read_cybergear(keys, joint, on);
  else if (protocol == "dronecan")
    read_dronecan(keys, joint);
  else
    keys.problems().push_back({keys.spec().line, keys.path() + ".driver", '"' + protocol + '"',
                               "one of \"cia402\", \"mit\", \"cybergear\", \"dronecan\""});
  return joint;
}

DeviceOpener read_can_servos(DeviceKeys& keys, const DeviceSpecs& specs) {
  std::vector<JointConfig> joints;
  const DeviceSpec& spec = keys.spec();
  for (const DeviceSpec& j : spec.joints) {
    DeviceKeys joint_keys(j, keys.path() + ".joint." + j.name, keys.problems());
    joints.push_back(read_joint(joint_keys, specs));
    joint_keys.finish();
  }
  if (joints.empty() || joints.size() > msg::kMaxChannels)
    keys.problems().push_back({spec.line, keys.path() + ".joint", std::to_string(joints.size()) + " joints",
                               "1 to " + std::to_string(msg::kMaxChannels) + ", each a [[" + keys.path() + ".joint]]"});
  return [joints = std::move(joints), name = spec.name](DeviceContext& context,
                                                        std::string& why) -> hal::Result<OpenedDevice> {
    const auto group = std::make_shared<ServoGroup>(context.os, name);
    context.can.hold(group);
    const auto report = std::make_shared<JointsReport>(group);
    for (const JointConfig& joint : joints) {
      auto bus = context.can.open(joint.bus, why);
      if (!bus) return bus.error();
      if ((*bus)->started) {
        why = "its bus runs already: ask for all devices before the start";
        return hal::Error{hal::Errc::bad_argument, "bus has started"};
      }
      if (auto added = group->add(*(*bus)->hub, joint.make(**bus)); !added) return added.error();
      report->add(joint, *(*bus)->hub);
    }
    OpenedDevice device;
    device.owner = report;
    device.report = report.get();
    device.actuators = group.get();
    device.sensor(hal::SensorKind::joints) = static_cast<hal::Joints*>(group.get());
    return device;
  };
}

DeviceOpener read_joints_of(DeviceKeys& keys, const DeviceSpecs& specs) {
  std::string group, groups;
  for (const DeviceSpec& d : specs.devices)
    if (d.driver == "can_servos") groups += (groups.empty() ? "" : ", ") + d.name;
  const std::string allowed = "the name of a device with can_servos: " + (groups.empty() ? "there is none" : groups);
  keys.require("group", group, allowed);
  const bool known = std::any_of(specs.devices.begin(), specs.devices.end(),
                                 [&](const DeviceSpec& d) { return d.name == group && d.driver == "can_servos"; });
  if (!group.empty() && !known) keys.problem("group", allowed);
  return [group](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto device = context.device(group, why);
    if (!device) return device.error();
    OpenedDevice joints;
    joints.owner = (*device)->owner;
    joints.sensor(hal::SensorKind::joints) = (*device)->sensor(hal::SensorKind::joints);
    return joints;
  };
}

}  // namespace sinew::drivers
