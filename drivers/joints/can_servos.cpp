#include "drivers/joints/can_servos.hpp"

#include <algorithm>

#include "drivers/joints/joint_words.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "drivers/joints/servo_group.hpp"

namespace sinew::drivers {
namespace {

bool has_joints(const DeviceSpec& d) { return d.driver == "can_servos" || d.driver == "serial_servos"; }

/// A group that words its complaints for the board: each names the joint, its protocol, number and bus.
class JointsReport final : public hal::SelfReport {
 public:
  explicit JointsReport(std::shared_ptr<ServoGroup> group) : group_(std::move(group)) {}
  void add(const JointConfig& joint, const JointHub& hub) {
    joints_.push_back({group_->name() + "." + joint.servo.name + " (" + joint.protocol + " " +
                           std::to_string(joint.servo.node_id) + " on " + joint.bus + ")",
                       &hub});
  }
  std::string trouble() const override {
    std::string all;
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      ServoFeedback said;
      if (!group_->feedback_of(i, said)) continue;  // its hub was writing; the next look reads it
      // For a second no joint is reported as absent: the bus has just been started, and drives answer one after the
      // other.
      const bool awaited = said.mode == msg::JointMode::absent && said.measured.ns == 0;
      if (awaited && static_cast<double>(joints_[i].hub->ticks()) < joints_[i].hub->tick_hz()) continue;
      std::string words = joint_words(said);
      if (words.empty()) words = refusal_words(said);
      if (words.empty()) words = beyond_words(said);
      if (!words.empty()) all += joints_[i].title + ": " + words + "\n";
    }
    return all;
  }

 private:
  struct Joint {
    std::string title;
    const JointHub* hub;
  };
  std::shared_ptr<ServoGroup> group_;
  std::vector<Joint> joints_;
};

/// Opens the joint's bus and adds its servo. Errors: in words in `why`.
hal::Status add_joint(const JointConfig& joint, ServoGroup& group, JointsReport& report, DeviceContext& context,
                      std::string& why) {
  const auto late = [&why] {
    why = "its bus runs already: ask for all devices before the start";
    return hal::Error{hal::Errc::bad_argument, "bus has started"};
  };
  if (joint.serial) {
    auto line = context.lines.open(joint.bus, why);
    if (!line) return line.error();
    if ((*line)->started) return late();
    report.add(joint, *(*line)->hub);
    return group.add(*(*line)->hub, joint.make_serial());
  }
  auto bus = context.can.open(joint.bus, why);
  if (!bus) return bus.error();
  if ((*bus)->started) return late();
  report.add(joint, *(*bus)->hub);
  return group.add(*(*bus)->hub, joint.make(**bus));
}

DeviceOpener read_servos(DeviceKeys& keys, const DeviceSpecs& specs, std::string_view driver, bool serial) {
  std::vector<JointConfig> joints;
  const DeviceSpec& spec = keys.spec();
  for (const DeviceSpec& j : spec.joints) {
    DeviceKeys joint_keys(j, keys.path() + ".joint." + j.name, keys.problems());
    joints.push_back(read_joint(joint_keys, specs));
    if (joints.back().serial != serial && !joint_keys.told("bus"))
      joint_keys.problem(
          "bus", "a joint of " + std::string(driver) + " is on a " + (serial ? "bus with driver serial" : "CAN bus"));
    joint_keys.finish();
  }
  if (joints.empty() || joints.size() > msg::kMaxChannels)
    keys.problems().push_back({spec.line, keys.path() + ".joint", std::to_string(joints.size()) + " joints",
                               "1 to " + std::to_string(msg::kMaxChannels) + ", each a [[" + keys.path() + ".joint]]"});
  return [joints = std::move(joints), name = spec.name, serial](DeviceContext& context,
                                                                std::string& why) -> hal::Result<OpenedDevice> {
    const auto group = std::make_shared<ServoGroup>(context.os, name);
    if (serial)
      context.lines.hold(group);
    else
      context.can.hold(group);
    const auto report = std::make_shared<JointsReport>(group);
    for (const JointConfig& joint : joints) {
      if (auto added = add_joint(joint, *group, *report, context, why); !added) return added.error();
    }
    OpenedDevice device;
    device.owner = report;
    device.report = report.get();
    device.actuators = group.get();
    device.sensor(hal::SensorKind::joints) = static_cast<hal::Joints*>(group.get());
    return device;
  };
}

}  // namespace

DeviceOpener read_can_servos(DeviceKeys& keys, const DeviceSpecs& specs) {
  return read_servos(keys, specs, "can_servos", false);
}
DeviceOpener read_serial_servos(DeviceKeys& keys, const DeviceSpecs& specs) {
  return read_servos(keys, specs, "serial_servos", true);
}

DeviceOpener read_joints_of(DeviceKeys& keys, const DeviceSpecs& specs) {
  std::string group, groups;
  for (const DeviceSpec& d : specs.devices)
    if (has_joints(d)) groups += (groups.empty() ? ": " : ", ") + d.name;
  const std::string allowed = "the name of a device with can_servos or serial_servos" + groups;
  keys.read("group", group, allowed, {.doc = "the joints of that one under this name, too", .required = true});
  const bool known = std::any_of(specs.devices.begin(), specs.devices.end(),
                                 [&](const DeviceSpec& d) { return d.name == group && has_joints(d); });
  if (!group.empty() && !known) keys.problem("group", groups.empty() ? allowed + ": there is none" : allowed);
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
