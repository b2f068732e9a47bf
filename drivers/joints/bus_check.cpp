#include "drivers/joints/bus_check.hpp"

#include <cmath>
#include <set>

#include "drivers/joints/bus_plan.hpp"
#include "drivers/joints/can_servos.hpp"
#include "drivers/joints/serial_buses.hpp"

namespace sinew::drivers {
namespace {

int line_of(const DeviceSpec& spec, std::string_view key) {
  const auto it = spec.keys.find(std::string(key));
  return it == spec.keys.end() ? spec.line : it->second.line;
}

/// One bus with all joints on it, made as for the open one and never run.
class PlannedBus {
 public:
  explicit PlannedBus(const DeviceSpec& spec) : spec_(spec) {
    std::vector<rt::Problem> told;
    DeviceKeys keys(spec, "", told);
    place_.config = read_can_bus(keys);
    place_.add = [this](std::unique_ptr<BusService> service) { services_.push_back(std::move(service)); };
  }
  PlannedBus(const PlannedBus&) = delete;
  PlannedBus& operator=(const PlannedBus&) = delete;

  void add(const DeviceSpec& group, const DeviceSpec& joint, const DeviceSpecs& specs) {
    std::vector<rt::Problem> told;
    DeviceKeys keys(joint, "", told);
    const JointConfig config = read_joint(keys, specs);
    if (config.bus != spec_.name || config.serial) return;
    joints_.push_back({joint, "device." + group.name + ".joint." + joint.name});
    servos_.push_back(config.make(place_));
  }

  void check(std::vector<rt::Problem>& problems) const {
    std::vector<const ServoProtocol*> servos;
    for (const auto& servo : servos_) servos.push_back(servo.get());
    for (const BusClash& c : find_clashes(servos))
      problems.push_back({line_of(joints_[c.second].spec, c.key), joints_[c.second].path + '.' + std::string(c.key),
                          std::to_string(c.number), c.why + " (bus " + spec_.name + ")"});
    const BusLoad load = plan_load(services_, servos, place_.config.hub.tick_hz, place_.config.spec.bit_rate);
    if (load.part > place_.config.hub.max_load)
      problems.push_back({line_of(spec_, "max_load_percent"), "bus." + spec_.name + ".max_load_percent",
                          std::to_string(std::lround(100 * place_.config.hub.max_load)), to_string(load)});
  }

 private:
  struct Joint {
    const DeviceSpec& spec;
    std::string path;
  };

  const DeviceSpec& spec_;
  BusPlace place_;
  std::vector<std::unique_ptr<BusService>> services_;
  std::vector<std::unique_ptr<ServoProtocol>> servos_;  // refer to services
  std::vector<Joint> joints_;
};

void check_names(const DeviceSpec& group, std::vector<rt::Problem>& problems) {
  std::set<std::string> names;
  for (const DeviceSpec& joint : group.joints)
    if (!names.insert(joint.name).second)
      problems.push_back({joint.line, "device." + group.name + ".joint." + joint.name, '"' + joint.name + '"',
                          "a name that no other joint of " + group.name + " has"});
}

/// One serial line with all joints on it, likewise.
class PlannedLine {
 public:
  PlannedLine(const DeviceSpec& spec, const DeviceSpecs& specs) : spec_(spec) {
    std::vector<rt::Problem> told;
    DeviceKeys keys(spec, "", told);
    rate_ = read_serial_bus(keys).hub.rate;
    for (const DeviceSpec& device : specs.devices)
      for (const DeviceSpec& joint : device.joints) {
        DeviceKeys joint_keys(joint, "", told);
        const JointConfig config = read_joint(joint_keys, specs);
        if (config.bus != spec.name || !config.make_serial) continue;
        placed_.push_back({joint, "device." + device.name + ".joint." + joint.name, config.make_serial()});
        servos_.push_back(placed_.back().servo.get());
      }
  }

  SerialPlan plan() const { return plan_serial(servos_, rate_); }
  bool is_empty() const { return servos_.empty(); }
  void check(std::vector<rt::Problem>& problems) const {
    for (const SerialClash& c : find_serial_clashes(servos_)) {
      const Placed& p = placed_[c.second];
      const std::string value = c.key == "id" ? std::to_string(p.servo->id()) : std::string(p.servo->model().name);
      problems.push_back({line_of(p.joint, c.key), p.path + '.' + c.key, value, c.why + " (bus " + spec_.name + ")"});
    }
    if (const SerialPlan sum = plan(); !sum.fits())
      problems.push_back(
          {line_of(spec_, "tick_hz"), "bus." + spec_.name + ".tick_hz", key_number(rate_.tick_hz), to_string(sum)});
  }

 private:
  struct Placed {
    const DeviceSpec& joint;
    std::string path;
    std::unique_ptr<SerialServo> servo;
  };
  const DeviceSpec& spec_;
  SerialLineRate rate_;
  std::vector<Placed> placed_;
  std::vector<const SerialServo*> servos_;
};

}  // namespace

std::vector<rt::Problem> check_buses(const DeviceSpecs& specs) {
  std::vector<rt::Problem> problems;
  for (const DeviceSpec& device : specs.devices) check_names(device, problems);
  for (const DeviceSpec& spec : specs.buses) {
    if (spec.driver == kSerialBus) {
      PlannedLine(spec, specs).check(problems);
      continue;
    }
    PlannedBus bus(spec);
    for (const DeviceSpec& device : specs.devices)
      for (const DeviceSpec& joint : device.joints) bus.add(device, joint, specs);
    bus.check(problems);
  }
  return problems;
}

std::vector<std::string> describe_buses(const DeviceSpecs& specs) {
  std::vector<std::string> all;
  for (const DeviceSpec& spec : specs.buses) {
    if (spec.driver != kSerialBus) continue;
    if (const PlannedLine line(spec, specs); !line.is_empty())
      all.push_back("bus " + spec.name + ": " + sum_text(line.plan()));
  }
  return all;
}

}  // namespace sinew::drivers
