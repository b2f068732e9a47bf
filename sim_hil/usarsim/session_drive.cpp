// DRIVE and MULTIDRIVE of a session: each class of robot has its own keys, and joints have names.
#include <algorithm>

#include "sim_hil/usarsim/session.hpp"
#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim {

using plant::Locomotion;
using wire::UsarLine;

void Session::refuse_drive(const char* type, const std::string& why) {
  unusable();
  refuse(type, why);
}

void Session::drive(const UsarLine& line) {
  if (const auto on = flag_of(line, "Light")) robot_->set_light(*on);
  const auto has = [&](const char* key) { return value_of(line, key).has_value(); };
  if (has("Name") && (has("Value") || has("Order") || has("Steps"))) return drive_joint(line);
  const plant::VehicleKind& kind = vehicle().kind();
  if (kind.steers()) return drive_steered(line);
  if (has("Speed") || has("FrontSteer") || has("RearSteer"))
    return refuse_drive("DRIVE", std::string(robot_->bot().kind->name) + " has no steered wheels: it is driven by " +
                                     (kind.locomotion == Locomotion::rotors
                                          ? "AltitudeVelocity, LinearVelocity, LateralVelocity, RotationalVelocity"
                                          : "Left and Right"));
  if (kind.locomotion == Locomotion::rotors) return drive_rotors(line);
  drive_wheels(line);
}

/// What a line does not name stays as it is. LateralVelocity is to the right, RotationalVelocity clockwise.
/// Source:  AerialVehicle.uc, Drive; altURI's airrobot.ini.
void Session::drive_rotors(const UsarLine& line) {
  const RobotClass& kind = *robot_->bot().kind;
  const bool normalized = flag_of(line, "Normalized").value_or(false);
  plant::VehicleCommand command = vehicle().driven();
  bool any = false;
  const auto take = [&](const char* key, double& into, double sign, double most) {
    const auto value = number_of(line, key);
    if (!value) return;
    any = true;
    into = sign * (normalized ? std::clamp(*value, -100.0, 100.0) / 100 * most : *value);
  };
  take("LinearVelocity", command.rotors.v_mps.x, 1, kind.normal_mps);
  take("LateralVelocity", command.rotors.v_mps.y, -1, kind.normal_mps);
  take("AltitudeVelocity", command.rotors.v_mps.z, 1, kind.normal_mps);
  take("RotationalVelocity", command.rotors.turn_radps, -1, kind.normal_radps);
  if (!any && !value_of(line, "Light")) return unusable();
  robot_->count_drive();
  vehicle().drive(command);
}

/// Source:  SkidSteeredVehicle.uc, Drive: both sides, or neither.
void Session::drive_wheels(const UsarLine& line) {
  if (const auto on = flag_of(line, "Normalized")) robot_->set_normalized(*on);
  const auto left = number_of(line, "Left"), right = number_of(line, "Right");
  if (!left || !right) {
    if (!value_of(line, "Light")) unusable();
    return;
  }
  const double scale = robot_->normalized() ? robot_->bot().kind->normal_radps / 100 : 1;
  plant::VehicleCommand command;
  command.left_radps = scale * *left, command.right_radps = scale * *right;
  robot_->count_drive();
  vehicle().drive(command);
}

/// The spin of all wheels and the angles of both axles, clockwise. What a line does not name stays as it is; a line
/// with a value that is no number changes nothing. Source:  AckermanSteeredVehicle.uc, Drive (which wants all three).
void Session::drive_steered(const UsarLine& line) {
  if (const auto on = flag_of(line, "Normalized")) robot_->set_normalized(*on);
  const plant::VehicleKind& kind = vehicle().kind();
  plant::VehicleCommand command = vehicle().driven();
  bool any = false;
  std::string wrong;
  const auto take = [&](const char* key, double& into, double sign, double most) {
    const auto text = value_of(line, key);
    if (!text) return;
    any = true;
    const auto value = number_in(*text);
    if (!value)
      wrong += (wrong.empty() ? "" : "; ") + std::string(key) + " '" + std::string(*text) + "' is no number";
    else
      into = sign * (robot_->normalized() ? std::clamp(*value, -100.0, 100.0) / 100 * most : *value);
  };
  take("Speed", command.steered.spin_radps, 1, robot_->bot().kind->normal_radps);
  take("FrontSteer", command.steered.front_rad, -1, kind.front_steer_rad);
  take("RearSteer", command.steered.rear_rad, -1, kind.rear_steer_rad);
  if (!wrong.empty()) return refuse_drive("DRIVE", wrong);
  if (!any) {
    if (!value_of(line, "Light"))
      refuse_drive("DRIVE", std::string(robot_->bot().kind->name) + " is driven by Speed, FrontSteer, RearSteer");
    return;
  }
  robot_->count_drive();
  vehicle().drive(command);
}

// ---- joints by name

namespace {

bool is_wheel(JointPart part) {
  return part == JointPart::left_wheel || part == JointPart::right_wheel || part == JointPart::driven_wheel;
}

}  // namespace

/// Turns one joint: `by_rate` nothing: as its kind does without an Order, wheels at a rate, other joints to an angle.
/// Returns why it does not, or an empty text.
std::string Session::move_joint(std::string_view name, std::string_view text, std::optional<bool> by_rate) {
  const RobotClass& kind = *robot_->bot().kind;
  const JointName* joint = find_joint(kind, name);
  if (!joint) return "no joint '" + std::string(name) + "'; " + kind.name + " has " + joint_names(kind);
  const auto value = number_in(text);
  if (!value) return std::string(name) + " '" + std::string(text) + "' is no number";
  if (is_wheel(joint->part) && by_rate == false) return std::string(name) + " turns at a rate: Order 1";
  plant::VehicleCommand command = vehicle().driven();
  switch (joint->part) {
    case JointPart::pan:
      vehicle().aim(plant::kPan, {by_rate.value_or(false), -*value});
      return {};
    case JointPart::tilt:
      vehicle().aim(plant::kTilt, {by_rate.value_or(false), -*value});
      return {};
    case JointPart::left_wheel:
      command.left_radps = *value;
      break;
    case JointPart::right_wheel:
      command.right_radps = *value;
      break;
    case JointPart::driven_wheel:
      command.steered.spin_radps = *value;
      break;
    case JointPart::front_steer:
    case JointPart::rear_steer:
      if (by_rate == true) return std::string(name) + " turns to an angle: Order 0";
      (joint->part == JointPart::front_steer ? command.steered.front_rad : command.steered.rear_rad) = -*value;
      break;
  }
  robot_->count_drive();
  vehicle().drive(command);
  return {};
}

/// DRIVE {Name joint} {Value v} [{Order 0|1}]: to an angle, or at a rate.
void Session::drive_joint(const UsarLine& line) {
  std::optional<bool> by_rate;
  if (const auto order = value_of(line, "Order")) {
    by_rate = is_rate(number_in(*order));
    if (!number_in(*order) || !by_rate)
      return refuse_drive("DRIVE", "Order '" + std::string(*order) + "': there are 0, an angle, and 1, a rate");
  }
  const auto value = value_of(line, "Value");
  if (!value) return refuse_drive("DRIVE", "a joint needs its Value; Steps are not known here");
  const std::string why = move_joint(*value_of(line, "Name"), *value, by_rate);
  if (!why.empty()) refuse_drive("DRIVE", why);
}

/// MULTIDRIVE {joint v} {joint v} ...: the joints that it has move, also when others of the line do not.
void Session::drive_joints(const UsarLine& line) {
  std::string wrong;
  for (const wire::UsarPart& part : line.parts()) {
    const std::string why = move_joint(part.key, part.value, std::nullopt);
    if (!why.empty()) wrong += (wrong.empty() ? "" : "; ") + why;
  }
  if (line.parts().empty()) wrong = "it names no joint; there are " + joint_names(*robot_->bot().kind);
  if (!wrong.empty()) refuse_drive("MULTIDRIVE", wrong);
}

}  // namespace sinew::usarsim
