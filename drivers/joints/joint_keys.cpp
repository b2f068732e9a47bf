// The keys that all joints have in common.
#include "drivers/joints/joint_keys.hpp"

#include <algorithm>
#include <array>

#include "drivers/joints/joint_reader.hpp"

namespace sinew::drivers {

void JointReader::refuse(const WrongKeys& wrong) {
  constexpr std::string_view kBus = "bus.";
  for (const WrongKey& w : wrong) {
    if (!w.key.starts_with(kBus)) {
      keys_.problem(w.key, w.allowed);
    } else if (bus_spec_) {  // once for all joints on it
      std::vector<rt::Problem> told;
      DeviceKeys bus_keys(*bus_spec_, "bus." + bus_spec_->name, told);
      static_cast<void>(read_can_bus(bus_keys));
      bus_keys.problem(w.key.substr(kBus.size()), w.allowed);
      std::vector<rt::Problem>& all = keys_.problems();
      const auto same = [&](const rt::Problem& p) { return p.key == told.back().key; };
      if (std::none_of(all.begin(), all.end(), same)) all.push_back(told.back());
    }
  }
}

void JointReader::read_bus() {
  std::string buses;
  for (const DeviceSpec& b : specs_.buses) buses += (buses.empty() ? ": " : ", ") + b.name;
  const std::string allowed = "the name of a [bus.NAME]" + buses;
  if (!keys_.read("bus", joint_.bus, allowed, {.doc = "the bus that it is on", .required = true})) return;
  const auto bus =
      std::find_if(specs_.buses.begin(), specs_.buses.end(), [&](const DeviceSpec& b) { return b.name == joint_.bus; });
  if (bus == specs_.buses.end()) return keys_.problem("bus", buses.empty() ? allowed + ": there is none" : allowed);
  bus_spec_ = &*bus;
  std::vector<rt::Problem> told;  // of the bus's own table
  DeviceKeys bus_keys(*bus, "", told);
  if ((bus->driver == kSerialBus) != joint_.serial)
    return keys_.problem("bus", joint_.serial ? "a [bus.NAME] with driver serial" : "a CAN bus");
  if (joint_.serial)
    line_ = read_serial_bus(bus_keys);
  else
    bus_ = read_can_bus(bus_keys);
}

void JointReader::read_place(std::int64_t most_id, Stops stops, std::string_view stop_doc) {
  read_bus();
  keys_.read_integer("id", c_.node_id, 1, most_id, {.doc = "its number on the bus", .required = true});
  keys_.read_choice<ServoMode>(
      "mode", c_.mode,
      {{"position", ServoMode::position}, {"velocity", ServoMode::velocity}, {"effort", ServoMode::effort}},
      {.doc = "what a setpoint is: rad, rad/s, N m"});
  keys_.read_choice<StopAction>("on_stop", c_.stop, stops, {.doc = stop_doc});
}

void JointReader::read_frame() {
  keys_.read("zero_rad", c_.zero_rad, -kMostRad, kMostRad,
             {.unit = "rad", .doc = "joint = sign * drive / gear_ratio - zero_rad"});
  bool reversed = false;
  if (keys_.read("reversed", reversed, {.doc = "the sign is -1"}) && reversed) c_.sign = -1;
  keys_.read("gear_ratio", c_.gear_ratio, 1e-3, 1e4, {.doc = "turns of what the drive measures per turn of the joint"});
}

void JointReader::read_limits() {
  ServoLimits& l = c_.limits;
  keys_.read("min_rad", l.position_min_rad, -kMostRad, kMostRad,
             {.unit = "rad", .doc = "setpoints are pulled in", .otherwise = "none"});
  keys_.read("max_rad", l.position_max_rad, -kMostRad, kMostRad,
             {.unit = "rad", .doc = "above min_rad; setpoints are pulled in", .otherwise = "none"});
  keys_.read("max_velocity_radps", l.velocity_radps, 1e-6, kMostRadps,
             {.unit = "rad/s", .doc = "of a setpoint, and of the change of a position setpoint"});
  keys_.read(
      "max_effort_nm", l.effort_nm, 1e-6, kMostNm,
      {.unit = "N m",
       .doc = joint_.protocol == "cia402" ? "also written into 6072h with each setpoint" : "of what is asked for",
       .otherwise = "as the drive is set"});
  keys_.read("derate_start_c", c_.derating.start_c, -50, 300,
             {.unit = "deg C", .doc = "from here on the limit of effort goes down", .otherwise = "never"});
  keys_.read("derate_end_c", c_.derating.end_c, -50, 300,
             {.unit = "deg C", .doc = "here it is nothing; above derate_start_c", .otherwise = "never"});
  const bool derates = keys_.has("derate_start_c") || keys_.has("derate_end_c");
  if (derates && !(c_.derating.start_c < c_.derating.end_c))
    keys_.problem("derate_end_c", "a number above derate_start_c, " + key_number(c_.derating.start_c));
}

void JointReader::read_watches(std::string_view usual_following) {
  keys_.read(
      "following_error_rad", c_.following.position_rad, 0, kMostRad,
      {.unit = "rad",
       .doc = "further behind its setpoint for following_time_ms: overload, off, and tried again; 0: not watched",
       .otherwise = usual_following});
  keys_.read_ms("following_time_ms", c_.following.time, 1, 60'000, {.doc = "see following_error_rad"});
  keys_.read_ms("feedback_timeout_ms", c_.feedback_timeout, 1, 10'000,
                {.doc = "silence for so long: the joint is lost; at least 2.5 times what lies between two answers"});
  keys_.read("plausible_velocity_radps", c_.plausible_velocity_radps, 0, kMostRadps,
             {.unit = "rad/s", .doc = "feedback that moves faster is disbelieved; 0: 4 times max_velocity_radps"});
  keys_.read("needs_disarm", c_.needs_disarm,
             {.doc = "after a fault, enabled again only after it was disarmed; a lease that was over is none"});
}

void JointReader::read_gains() {
  keys_.read("kp", c_.kp, 0, kMostNm,
             {.unit = "N m/rad", .doc = "at most what the motor takes", .otherwise = "required for mode position"});
  keys_.read("kd", c_.kd, 0, kMostNm,
             {.unit = "N m s/rad",
              .doc = "at most what the motor takes",
              .otherwise = "required for mode position and velocity"});
  keys_.read("damp_kd", c_.damp_kd, 0, kMostNm, {.unit = "N m s/rad", .doc = "of on_stop damp", .otherwise = "as kd"});
}

void JointReader::read_device_timeout() {
  keys_.read_ms("device_timeout_ms", c_.device_timeout, 0, 10'000,
                {.doc = joint_.protocol == "cia402"
                            ? "the drive stops when our heartbeat is away for so long (1016h), at least 3 times the "
                              "bus's tick and master_heartbeat_ms; 0: as the drive is set"
                            : "the motor stops when it hears nothing for so long (CAN_TIMEOUT), at least 3 times the "
                              "bus's tick; 0: as the motor is set"});
}

constexpr std::array<std::string_view, 6> kProtocols{"cia402", "mit", "cybergear", "dronecan", "dynamixel", "feetech"};

JointConfig JointReader::read() {
  const std::string& protocol = keys_.spec().driver;
  if (protocol == "cia402")
    read_cia402();
  else if (protocol == "mit")
    read_mit();
  else if (protocol == "cybergear")
    read_cybergear();
  else if (protocol == "dronecan")
    read_dronecan();
  else if (protocol == "dynamixel")
    read_serial(wire::ServoMaker::robotis);
  else if (protocol == "feetech")
    read_serial(wire::ServoMaker::feetech);
  else
    keys_.refuse_driver(kProtocols);
  joint_.servo = c_;
  return std::move(joint_);
}

std::span<const std::string_view> joint_protocols() { return kProtocols; }

JointConfig read_joint(DeviceKeys& keys, const DeviceSpecs& specs) { return JointReader(keys, specs).read(); }

}  // namespace sinew::drivers
