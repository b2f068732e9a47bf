#pragma once
// A soccer field with robots and a ball: the true physics, servos and sensors with the errors of real ones.
//
//   PitchBody kid{.body = loaded.body, .start = {.x_m = -1}};
//   auto pitch = Pitch::create({}, {&kid, 1}, seed);
//   (*pitch)->command(0, targets_rad);              // each 10 ms, say
//   (*pitch)->step();                               // 2 ms
//   (*pitch)->sensors(0).joint[3].position_rad;     // what the robot knows
//   (*pitch)->truth(0).fallen;                      // what is so
//
// Programs that use it link sinew_exact_mujoco: then the same seed and commands give the same bytes on every machine.
// Frames:  world: x along the field, y left, z up, 0 in the middle; a robot's axes are those of its body's links.
// Thread:  owner.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "kinematics/body.hpp"
#include "math/lens.hpp"
#include "sim_hil/pitch/field.hpp"
#include "sim_hil/worlds/body_errors.hpp"
#include "sim_hil/worlds/joints.hpp"

namespace sinew::plant {

inline constexpr std::int64_t kPitchStepNs = 2'000'000;
inline constexpr std::size_t kMostJoints = kinematics::kMaxLinks - 1;

/// Where a robot is put: it stands or lies on the ground with its lowest point just above it.
struct PitchPlace {
  double x_m = 0, y_m = 0, heading_rad = 0;
  enum class Lie : std::uint8_t { upright, on_front, on_back, on_left, on_right } lie = Lie::upright;
  std::vector<double> joints_rad{};  // missing ones are 0
};

struct PitchBody {
  enum class Kind : std::uint8_t { legged, wheeled } kind = Kind::legged;  // wheeled: pioneer_body() of wheeled.hpp
  kinematics::Body body;
  PitchPlace start{};
  BodyErrors errors{};
  double gain_per_rad = 4.6;  // of every servo: share of the voltage for a radian; XM430's factory setting (P gain 800)
  std::uint8_t team = 0;      // 0 blue, 1 red
  double focal_per_height = 0.875;  // of its cameras: focal length as a share of the picture's height
};

/// A printed chessboard of 10 x 7 squares with a white rim of one square, for calibration.
struct PitchBoard {
  double square_m = 0;                                     // 0: there is none
  double x_m = 0, y_m = 0, heading_rad = 0, lean_rad = 0;  // as the options of the world "soccer"
  /// Its first inner corner in the world: x along its rows, to the right for somebody before it, y down, z into it.
  kinematics::Pose pose() const;
};
inline constexpr int kBoardColumns = 9, kBoardRows = 6;  // inner corners

/// A wall of this size stands across the field: what is behind it is out of sight of low cameras.
struct PitchWall {
  double high_m = 0;  // 0: there is none
  double x_m = 0, from_y_m = 0, to_y_m = 0;
  double thick_m = 0.06;
};

struct PitchOptions {
  /// Without dynamics, for long tests of behaviour: the lowest foot of a robot is fixed to the flat ground and the body
  /// moves over it; joints and wheels turn at the speed that they can; robots neither fall nor touch each other; pushes
  /// do nothing; feet, paddles and posts move the ball.
  bool kinematic = false;
  GroundErrors ground{};
  FieldSize field{};
  BallSize ball{};
  bool has_ball = true;
  bool orange_ball = false;  // for robots that find it by its colour; else white with black, as in the league
  PitchPlace ball_at{};      // x_m, y_m
  PitchBoard board{};
  PitchWall wall{};                 // without dynamics robots and ball pass through it
  double focal_per_height = 0.875;  // of the cameras of a painter's scenes
  math::LensDistortion lens{};      // of all cameras
};

struct JointReading {
  double position_rad = 0;  // of the encoder
  double velocity_radps = 0;
  double effort_nm = 0;  // by the motor's current
  double temperature_c = 25;
};

/// What a robot's own devices said last, each part with the time it was measured at; it is older by its delay.
struct BodySensors {
  std::int64_t joints_stamp_ns = 0;
  std::size_t joints = 0;
  std::array<JointReading, kMostJoints> joint{};
  std::int64_t imu_stamp_ns = 0;
  math::Vec3 gyro_radps, accel_mps2;  // in the IMU's axes; accel is 9.81 upwards at rest
  std::int64_t cells_stamp_ns = 0;
  std::array<std::array<double, 4>, 2> cell_n{};  // left, right foot: front left, front right, back left, back right
};

/// What is so: for referees, tests and reports; no robot sees it.
struct BodyTruth {
  kinematics::Pose torso;                                      // link 0 in the world
  math::Vec3 v_world_mps, gyro_radps;                          // of its origin, in the world; in its own axes
  std::array<kinematics::Pose, kinematics::kMaxLinks> link{};  // in the world
  std::array<double, kMostJoints> joint_rad{}, joint_radps{};
  std::array<double, 2> foot_n{};  // force on the left and the right sole
  bool body_down = false;          // something other than its soles touches the ground
  double tilt_rad = 0;             // of the torso's z from the vertical
  bool fallen = false;             // tilted by more than 60 degrees
};

struct BallTruth {
  math::Vec3 p_m, v_mps, spin_radps;
  math::Quat q;
  int touched_by = -1;  // the robot that touched it last; -1: none
};

class Pitch {
 public:
  /// Errors: bad_argument (`why` says which: no body, a link without mass that a joint moves, two robots in one place),
  ///         bad_data (MuJoCo refuses the model).
  static hal::Result<std::unique_ptr<Pitch>> create(const PitchOptions& options, std::span<const PitchBody> bodies,
                                                    std::uint64_t seed, std::string* why = nullptr);
  virtual ~Pitch() = default;

  virtual std::size_t robots() const = 0;
  virtual const kinematics::Body& body(std::size_t robot) const = 0;  // with its true masses
  virtual std::int64_t now_ns() const = 0;
  /// Advances by kPitchStepNs.
  virtual void step() = 0;

  // Commands reach the servos after the robot's command delay.
  /// One angle for each joint in the body's order; NaN: this joint gives no torque. Missing ones stay as they are.
  virtual void command(std::size_t robot, std::span<const double> targets_rad) = 0;
  virtual void command(std::size_t robot, std::size_t joint, const JointDrive& drive) = 0;
  /// The largest share of the voltage that a servo may use, 0 to 1: its torque limit. At once.
  virtual void limit(std::size_t robot, std::size_t joint, double share) = 0;
  /// Share of the voltage for a radian of error. At once.
  virtual void gain(std::size_t robot, std::size_t joint, double gain_per_rad) = 0;

  virtual const BodySensors& sensors(std::size_t robot) const = 0;
  virtual const BodyTruth& truth(std::size_t robot) const = 0;
  virtual const BallTruth& ball() const = 0;
  /// How often MuJoCo warned (no room for contacts, a state that is no number): 0 in a run that means something.
  virtual std::uint64_t trouble() const = 0;
  /// What a joint's encoder reads where it is at 0; the servo's targets are off by as much.
  virtual double joint_zero_rad(std::size_t robot, std::size_t joint) const = 0;
  /// The command delay that the robot has in this run.
  virtual std::int64_t command_delay_ns(std::size_t robot) const = 0;

  /// An impulse in the world's axes on the torso's centre of mass, evenly over this time.
  virtual void push(std::size_t robot, const math::Vec3& impulse_ns, std::int64_t duration_ns) = 0;
  /// On the ground unless p_m.z is above; nobody has touched it since.
  virtual void place_ball(const math::Vec3& p_m, const math::Vec3& v_mps = {}) = 0;
  /// At rest; pushes end. Its servos go on with their commands.
  virtual void place(std::size_t robot, const PitchPlace& at) = 0;
};

}  // namespace sinew::plant
