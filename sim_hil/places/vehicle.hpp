#pragma once
#include <array>
#include <string>

#include "math/random.hpp"
#include "sim_hil/places/motion.hpp"
#include "sim_hil/worlds/joints.hpp"
#include "sim_hil/worlds/sensors.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

class Place;

/// The commands to a vehicle: those of its locomotion act, the others mean nothing.
struct VehicleCommand {
  RotorCommand rotors;
  double left_radps = 0, right_radps = 0;  // wheels
  SteerCommand steered{};                  // wheels of a kind that steers
};

/// How one joint of the camera is driven: its mounting holds what it was last told.
struct CameraDrive {
  bool by_rate = false;
  double value = 0;  // rad, or rad/s
};
enum CameraJoint : std::size_t { kPan = 0, kTilt = 1 };
inline constexpr std::size_t kCameraJoints = 2;

struct CameraState {
  std::array<double, kCameraJoints> position_rad{}, rate_radps{};
};

/// One vehicle of a place. As SimRobot it is what a session of the own protocol serves: actuators of 6 channels, see
/// robots/air_robot/devices.hpp.
/// Frames:  pan to the left, tilt downwards are positive.
/// Thread:  the place's.
class Vehicle final : public SimRobot, private PlantJoints {
 public:
  struct Start {
    math::Vec3 p_world_m;  // of base
    double yaw_rad = 0;
  };
  struct Options {
    std::uint64_t seed = 1;
    bool sensor_errors = true;
    double battery_charge = 1;  // 0..1
  };
  Vehicle(Place& place, std::size_t slot, const VehicleKind& kind, const Start& start, const Options& options);

  const VehicleKind& kind() const { return *kind_; }
  std::size_t slot() const { return slot_; }

  // ---- commands
  void drive(const VehicleCommand& command) { command_ = command; }
  const VehicleCommand& driven() const { return command_; }
  void aim(CameraJoint joint, const CameraDrive& drive) { camera_drive_[joint] = drive; }
  /// The half angle of the picture's height changes with it; 0: the kind's own.
  void zoom(double focal_per_height) { focal_per_height_ = focal_per_height; }
  void put(const Start& start);
  /// The 6 channels of the own protocol; none: stands, or hovers.
  void take(RobotCommand command);

  // ---- the truth
  const BodyState& body() const { return body_; }
  const CameraState& camera() const { return camera_; }
  const WheelMotion& wheels() const { return wheels_; }
  CameraPose camera_pose() const;
  double focal_per_height() const { return focal_per_height_ > 0 ? focal_per_height_ : kind_->focal_per_height; }
  bool turns_rotors() const { return kind_->locomotion == Locomotion::rotors && powered() && !body_.stands; }
  bool powered() const { return battery_s_ > 0; }
  double battery_s() const { return battery_s_; }     // until it is empty
  double driven_m() const { return driven_m_; }       // the way so far
  double highest_m() const { return highest_m_; }     // of base, over the place's z = 0
  std::uint32_t touches() const { return touches_; }  // how often it began to touch something
  /// The ball that others meet.
  Solid hull() const;

  // ---- SimRobot
  const Due& due() const override { return due_; }
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override;
  std::uint32_t news() const override { return touches_; }
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;
  PlantJoints* joints() override { return this; }

  /// A step of the place's; then its samples.
  void step(const Surroundings& around, double dt_s);
  void sample(std::int64_t steps, const Surroundings& around);

 private:
  // ---- PlantJoints: the camera's, for simulated drives. Their efforts are not modelled: 0.
  std::size_t count() const override { return kCameraJoints; }
  JointMotion motion(std::size_t joint) const override;
  JointLimits limits(std::size_t joint) const override;
  void drive(std::size_t joint, const JointDrive& drive) override { taken_[joint] = drive; }
  void release(std::size_t joint) override { taken_[joint].reset(); }
  CameraDrive camera_drive(std::size_t joint) const;

  void step_camera(double dt_s);
  void watch_target(msg::Time now, double dt_s);

  Place* place_;
  std::size_t slot_;
  const VehicleKind* kind_;
  BodyState body_;
  RotorMotion rotors_;
  WheelMotion wheels_;
  VehicleCommand command_;
  std::array<CameraDrive, kCameraJoints> camera_drive_{};
  std::array<std::optional<JointDrive>, kCameraJoints> taken_{};  // by another drive's command than the group's
  CameraState camera_;
  double focal_per_height_ = 0;
  double battery_s_ = 0, driven_m_ = 0, highest_m_ = 0;
  std::uint32_t touches_ = 0;
  bool touched_ = false, moved_ = false;

  ImuModel imu_;
  RangeModel range_;
  BaroModel baro_;
  BatteryModel battery_;
  math::Random noise_;
  bool errors_;
  math::Vec3 gyro_sum_, accel_sum_;  // since the last IMU sample
  std::uint32_t next_frame_ = 1;
  Due due_;
  // The target in its camera's view.
  double watched_s_ = 0, in_view_s_ = 0, off_axis2_ = 0, distance_sum_ = 0;
  double loss_s_ = 0, longest_loss_s_ = 0;
  double middle_s_ = 0;
  bool found_ = false;  // from then on all of this counts
  // Over the target: horizontally from base.
  double over_m_ = 0;  // lately: mean over kLately_s
  double wind_max_mps_ = 0;
  msg::Time reached_;  // 0: never was so near
};

}  // namespace sinew::plant
