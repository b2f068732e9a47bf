#pragma once
// The joints of a world's actuator group, for simulated drives.
#include <cstddef>
#include <cstdint>

namespace sinew::plant {

enum class DriveMode : std::uint8_t {
  off,        // no torque; the gear still rubs
  position,   // the drive's own cascade towards position_rad, within the joint's largest speed and effort
  velocity,   // towards velocity_radps
  effort,     // effort_nm
  impedance,  // kp * (position_rad - q) + kd * (velocity_radps - q') + effort_nm: what MIT-style motors do
};

/// The command to the drive of one joint.
struct JointDrive {
  DriveMode mode = DriveMode::off;
  double position_rad = 0, velocity_radps = 0, effort_nm = 0;
  double kp_nm_per_rad = 0, kd_nms_per_rad = 0;  // impedance only
};

/// The true motion of one joint: no sensor is in between.
struct JointMotion {
  double position_rad = 0, velocity_radps = 0;
  double effort_nm = 0;  // of the motor in the last plant step, at the joint
  double temperature_c = 25;
  JointDrive drive;  // the command that it obeyed in that step
};

struct JointLimits {
  double least_rad = 0, most_rad = 0;  // hard stops
  double speed_radps = 0, effort_nm = 0;
};

/// The actuator group's command drives all joints by position. Others, for example the simulated drives of a field bus,
/// may take single joints over and give them back.
/// Thread:  the world's owner, between two steps.
class PlantJoints {
 public:
  virtual ~PlantJoints() = default;
  virtual std::size_t count() const = 0;
  /// joint < count(), here and below.
  virtual JointMotion motion(std::size_t joint) const = 0;
  virtual JointLimits limits(std::size_t joint) const = 0;
  /// From the next step until release(), this joint obeys `drive`, whatever the group's commands say.
  virtual void drive(std::size_t joint, const JointDrive& drive) = 0;
  virtual void release(std::size_t joint) = 0;
};

}  // namespace sinew::plant
