// The keys of each protocol beside those of joint_keys.cpp, and the function that makes the protocol.
#include <algorithm>
#include <charconv>
#include <optional>

#include "drivers/joints/cia402_servo.hpp"
#include "drivers/joints/cybergear_servo.hpp"
#include "drivers/joints/dronecan_servo.hpp"
#include "drivers/joints/joint_reader.hpp"

namespace sinew::drivers {
namespace {

hal::Duration from_ms(double ms) { return hal::Duration{static_cast<std::int64_t>(ms * 1e6)}; }

constexpr std::string_view kImpedanceStop =
    "what it does when the lease is over or a command is bad; hold: mode position";
constexpr std::string_view kSpring = "0.5 and what its most effort bends it";

/// 32 hexadecimal digits; nothing: there are none, or a problem was noted.
std::optional<wire::DronecanUniqueId> read_unique_id(DeviceKeys& keys) {
  constexpr const char* kAllowed = "32 hexadecimal digits";
  std::string text;
  if (!keys.read("unique_id", text, kAllowed, {.doc = "a node that asks for a node id with this one gets this `id`"}))
    return std::nullopt;
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

}  // namespace

Pace JointReader::tick() const { return {from_ms(1e3 / bus_.hub.tick_hz), "the bus's tick_hz"}; }

void JointReader::read_cia402() {
  read_place(
      wire::kMaxCanopenNode,
      {{"torque_off", StopAction::torque_off}, {"quick_stop", StopAction::quick_stop}, {"hold", StopAction::hold}},
      "what it does when the lease is over or a command is bad; hold: not in mode effort");
  read_frame();
  keys_.read("counts_per_turn", c_.counts_per_turn, 1, 1e9,
             {.doc = "of the drive's position unit, per turn of what it measures", .required = true});
  keys_.read("rated_effort_nm", c_.rated_effort_nm, 0, kMostNm,
             {.unit = "N m", .doc = "what 1000 per mille of 6071h and 6077h are", .otherwise = "the drive's 6076h"});
  read_limits();
  read_watches("0.5");
  read_device_timeout();
  keys_.read_integer(
      "homing_method", c_.homing_method, -128, 127,
      {.doc = "6098h: **the joint moves by itself** when it is enabled for the first time", .allowed = kHomingMethods});
  Cia402Options o;
  o.tick_hz = bus_.hub.tick_hz;
  o.master_node = bus_.master_node;
  keys_.read_integer("slow_every", o.slow_every, 1, 240, {.doc = "velocity and voltage come with every n-th SYNC"});
  keys_.read("velocity_unit_radps", o.velocity_unit_radps, 0, kMostRadps,
             {.unit = "rad/s", .doc = "of 60FFh and 606Ch, drive side", .otherwise = "counts per second"});
  keys_.read_integer(
      "temperature_index", o.temperature_object.index, 0x2000, 0x9FFF,
      {.doc = "the maker's object with a temperature, read once a second", .otherwise = "none", .hex = true});
  keys_.read_integer("temperature_sub", o.temperature_object.sub, 0, 254, {.doc = "its subindex"});
  keys_.read("temperature_unit_c", o.temperature_unit_c, 1e-6, 1e3, {.unit = "deg C", .doc = "what its 1 is"});
  refuse(check_cia402(c_, o));
  const Pace heartbeat{bus_.master_heartbeat, "the bus's master_heartbeat_ms"};
  refuse(check_times(c_, tick(), heartbeat.every > tick().every ? heartbeat : tick()));
  joint_.make = [config = c_, o](BusPlace& on) -> std::unique_ptr<ServoProtocol> {
    if (!on.has_canopen_master)
      on.add(
          std::make_unique<CanopenMaster>(CanopenMaster::Options{on.config.master_node, on.config.master_heartbeat}));
    on.has_canopen_master = true;
    return std::make_unique<Cia402Servo>(config, o);
  };
}

void JointReader::read_mit_ranges(MitOptions& o, bool custom) {
  const std::string_view otherwise = "the motor's; required for \"custom\"";
  const auto read = [&](std::string_view key, double& range, double most, std::string_view unit) {
    const bool given =
        keys_.read(key, range, 1e-3, most,
                   {.unit = unit, .doc = "full scale in its frames, as its firmware is set", .otherwise = otherwise});
    if (custom && !given && !keys_.has(key))
      keys_.problem(key, "a number from 0.001 to " + key_number(most) + "; required with motor = \"custom\"");
  };
  read("range_position_rad", o.type.position_rad, 1e4, "rad");
  read("range_velocity_radps", o.type.velocity_radps, 1e4, "rad/s");
  read("range_effort_nm", o.type.effort_nm, 1e4, "N m");
  read("range_kp", o.type.kp, 1e5, "N m/rad");
  read("range_kd", o.type.kd, 1e4, "N m s/rad");
}

void JointReader::read_mit() {
  read_place(255, {{"torque_off", StopAction::torque_off}, {"damp", StopAction::damp}, {"hold", StopAction::hold}},
             kImpedanceStop);
  std::string types = "one of \"custom\"", name;
  for (const wire::MitMotorType& t : wire::mit_motor_types()) types += ", \"" + std::string(t.name) + '"';
  keys_.read("motor", name, types, {.doc = "its type; custom: by its ranges", .required = true});
  MitOptions o;
  if (const wire::MitMotorType* known = wire::mit_motor_type(name))
    o.type = *known;
  else if (!name.empty() && name != "custom")
    keys_.problem("motor", types);
  read_mit_ranges(o, name == "custom");
  read_gains();
  read_frame();
  read_limits();
  read_watches(kSpring);
  keys_.read_integer("master_id", o.master_id, 0, 0x7FF,
                     {.doc = "the identifier of its replies; several motors may share it", .hex = true});
  joint_.replies_as = o.master_id;
  refuse(check_mit(c_, o));
  refuse(check_times(c_, tick(), tick()));
  joint_.make = [config = c_, o](BusPlace&) -> std::unique_ptr<ServoProtocol> {
    return std::make_unique<MitServo>(config, o);
  };
}

void JointReader::read_cybergear() {
  read_place(127, {{"torque_off", StopAction::torque_off}, {"damp", StopAction::damp}, {"hold", StopAction::hold}},
             kImpedanceStop);
  read_gains();
  read_frame();
  read_limits();
  read_watches(kSpring);
  read_device_timeout();
  std::uint32_t host = 0xFD;
  keys_.read_integer("host_id", host, 0, 0xFF, {.doc = "our own number; another than the motor's id", .hex = true});
  refuse(check_cybergear(c_, host));
  refuse(check_times(c_, tick(), tick()));
  joint_.make = [config = c_, host](BusPlace&) -> std::unique_ptr<ServoProtocol> {
    return std::make_unique<CyberGearServo>(config, host);
  };
}

void JointReader::read_dronecan() {
  read_place(
      wire::kDronecanMaxNode,
      {{"torque_off", StopAction::torque_off}, {"damp", StopAction::damp}, {"hold", StopAction::hold}},
      "has to say what the device does when it is sent nothing: hold (mode position), damp (velocity), torque_off "
      "(effort, ESCs)");
  DronecanServoOptions o;
  keys_.read_integer(
      "actuator_id", c_.actuator_id, 0, 255,
      {.doc = "its place in the commands, once on a bus among actuators and once among ESCs, there at most 19",
       .required = true});
  keys_.read("esc", o.esc, {.doc = "an ESC (mode velocity), not an actuator"});
  keys_.read("esc_full_radps", o.esc_full_radps, 1e-3, kMostRadps,
             {.unit = "rad/s", .doc = "drive speed at the full command", .otherwise = "required for an ESC"});
  keys_.read("status_hz", o.status_hz, 0.1, 2000, {.unit = "Hz", .doc = "how often the device tells its status"});
  read_frame();
  read_limits();
  read_watches("0.5");
  const auto unique_id = read_unique_id(keys_);
  refuse(check_dronecan(c_, o));
  if (c_.node_id == bus_.dronecan.node_id) keys_.problem("id", "another number than the bus's dronecan_node");
  refuse(check_times(c_, {from_ms(1e3 / o.status_hz), "status_hz"}, {}));
  joint_.make = [config = c_, o, unique_id](BusPlace& on) -> std::unique_ptr<ServoProtocol> {
    if (!on.dronecan) {
      auto node = std::make_unique<DronecanNode>(on.config.dronecan);
      on.dronecan = node.get();
      on.add(std::move(node));
    }
    if (unique_id) on.dronecan->allocate(*unique_id, static_cast<std::uint8_t>(config.node_id));
    return std::make_unique<DronecanServo>(config, o, *on.dronecan);
  };
}

void JointReader::read_serial(wire::ServoMaker maker) {
  joint_.serial = true;
  const std::uint8_t most_id = maker == wire::ServoMaker::robotis ? wire::kDxlMostId2 : wire::kDxlMostId1;
  read_place(most_id, {{"torque_off", StopAction::torque_off}, {"hold", StopAction::hold}},
             "what it does when the lease is over or a command is bad; hold: not in mode effort");
  SerialServoOptions o;
  std::string models = "one of", name;
  for (const wire::ServoModel& m : wire::servo_models())
    if (m.maker == maker) models += (models.back() == 'f' ? " \"" : ", \"") + std::string(m.name) + '"';
  if (keys_.read("model", name, models, {.doc = "its type", .required = true})) {
    o.model = wire::servo_model(name);
    if (o.model && o.model->maker != maker) o.model = nullptr;
    if (!o.model) keys_.problem("model", models);
  }
  read_frame();
  read_limits();
  read_watches("0.5");
  const bool timed = keys_.read_ms(
      "device_timeout_ms", c_.device_timeout, 0, 2540,
      {.doc =
           "the servo stops where it is, with torque, when it hears nothing for so long (bus watchdog, X series), at "
           "least 3 times the bus's tick; 0: never",
       .otherwise = "200 or 4 ticks, where it has a bus watchdog"});
  if (!o.model) return;
  const Pace tick{from_ms(1e3 / line_.hub.rate.tick_hz), "the bus's tick_hz"};
  if (!timed && o.model->bus_watchdog)
    c_.device_timeout = std::max<hal::Duration>(std::chrono::milliseconds(200), 4 * tick.every);
  refuse(check_serial_servo(c_, o));
  refuse(check_times(c_, tick, tick));
  joint_.make_serial = [config = c_, o] { return std::make_unique<SerialServo>(config, o); };
}

}  // namespace sinew::drivers
