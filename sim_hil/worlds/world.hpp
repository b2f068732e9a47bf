#pragma once
// Every simulated world, as the session with a runtime sees it: steps, samples, a picture, a word for the report.
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"
#include "msg/joints.hpp"
#include "msg/referee.hpp"
#include "msg/sensors.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::kinematics {
struct Body;
}

namespace sinew::plant {

class JsonObject;
class PlantJoints;
struct WorldChoice;

inline constexpr std::int64_t kStepNs = 250'000;
inline constexpr int kImuSteps = 4, kTruthSteps = 40;  // 1 kHz, 100 Hz
inline constexpr int kCameraHz = 30;

/// Stamp (mid-point of the exposure) of the frame with this number, counted from 1: multiples of 1/30 s on the grid of
/// the plant's steps.
constexpr std::int64_t camera_stamp_ns(std::uint32_t frame) {
  const std::int64_t exact = std::int64_t{frame} * 1'000'000'000 / kCameraHz;
  return (exact + kStepNs / 2) / kStepNs * kStepNs;
}

inline constexpr double kGravity = 9.81;
inline constexpr double kFocalPerHeight = 0.875;  // unless a world says otherwise: fx = fy = 420 px at 640x480

enum class Part : std::uint8_t { imu, range, baro, camera, actuators, battery, joints, soles, referee };
inline constexpr std::size_t kParts = 9;
/// Of one robot: groups of joints and of actuators, and cameras.
inline constexpr std::size_t kMostGroups = 6, kMostCameras = 4;

/// As DriverKind::measures has it: "imu".
std::string_view to_string(Part part);

/// One device of a world.
struct WorldDevice {
  Part part{};
  const char* name = "";
  int steps = 0;              // plant steps from sample to sample; 0: at no fixed period, cameras: kCameraHz
  std::int64_t delay_ns = 0;  // stamp to availability
  std::uint32_t channels = 0;
  FaultDevice fault{};
  double least = 0, most = 0;        // actuators: the sensible range of a command, in its unit
  std::optional<FaultDevice> bus{};  // joints: actuators that are on the same bus, and lost with it
};

/// A number that a world lets its user choose. From this table come the keys of [sim] in a robot file with their check,
/// the options of sinew-sim and docs/reference/world-options.md.
struct WorldOption {
  const char* key = "";     // in [sim], with its unit: "gust_mps"
  const char* option = "";  // of sinew-sim, without dashes: "gust", for --gust
  const char* unit = "";    // empty: none
  double least = 0, most = 0;
  std::optional<double> value{};  // the default; none: as `otherwise` says
  const char* otherwise = "";     // "by the seed, up to half of gust_mps"
  const char* doc = "";
  bool whole = false;      // whole numbers only
  bool per_robot = false;  // where several robots share the world, each has its own

  /// False also for NaN.
  bool allows(double number) const;
  /// "a number from 0 to 15 m/s", "an integer from 0 to 1".
  std::string allowed() const;
};
/// By WorldOption::key; options that are missing here have their own default.
using WorldValues = std::map<std::string, double, std::less<>>;
inline constexpr std::size_t kMostRobots = 8;  // in one world
inline constexpr const char* kRadioName = "radio";

/// What a robot of a world has on board, in the order of the Welcome; and what its user may choose. Cameras, groups of
/// actuators and groups of joints may be there several times, other parts once.
/// A world with robots of several kinds has here those of the kind with the most cameras, and `as_robot`.
struct WorldInfo {
  const char* name = "";
  std::span<const WorldDevice> devices;
  std::span<const WorldOption> options{};
  std::size_t most_robots = 1;
  bool has_bodies = false;  // of robots, which a file describes (docs/bodies.md): WorldChoice::body
  /// This world as a robot with these values has it: its devices, and whether a file describes its body. Null: all
  /// robots are alike.
  WorldInfo (*as_robot)(const WorldInfo& world, const WorldValues& robot) = nullptr;

  WorldInfo of(const WorldValues& robot) const { return as_robot ? as_robot(*this, robot) : *this; }

  /// The first one; null when it has none.
  const WorldDevice* find(Part part) const;
  std::size_t count(Part part) const;
  /// The actuators' and the joints' channels of all groups together, in the order of the groups.
  std::uint32_t channels(Part part) const;
  bool has(FaultDevice device) const;
  /// Its robots have a radio each, named kRadioName, and an air between them.
  bool has_radio() const { return most_robots > 1; }
  /// The option with this key; null: the world has none.
  const WorldOption* find_option(std::string_view key) const;
  /// The value of an option in `values`, or its own default; nothing: it has none.
  std::optional<double> value(const WorldValues& values, std::string_view key) const;
};

/// The samples that the step that just ended made available. They carry their stamps; delays are not applied yet.
struct Due {
  bool imu = false, range = false, baro = false, battery = false, joints = false, soles = false, referee = false;
  bool truth = false;
  std::uint32_t cameras = 0;  // bit i: camera i takes a picture now
  msg::ImuSample imu_sample;
  msg::RangeSample range_sample;
  msg::BaroSample baro_sample;
  msg::BatterySample battery_sample;
  msg::SolePressure soles_sample;
  msg::RefereeState referee_sample;
  std::array<msg::JointState, kMostGroups> joints_samples;  // of each group
};

/// The pose of a thing: its position, and the rotation that takes its coordinates to the world's.
struct Pose {
  msg::Vec3 p_world_m;
  msg::Quat q_world;
};

/// Pose of the camera, and its focal length as a share of the picture's height.
struct CameraPose {
  msg::Vec3 p_world_m;
  msg::Quat q_world_optical;
  double focal_per_height = kFocalPerHeight;
};

/// All that a picture depends on: the camera, and the moving things in its sight, in the order of the room's mocap
/// bodies.
struct Scene {
  static constexpr std::size_t kMost = 288;  // eight bodies of 32 links, and what they play with
  CameraPose camera;
  std::array<Pose, kMost> body{};
  std::size_t bodies = 0;
  // For a room whose robots hang on no joint: where each is. A camera of a robot that is alone shows none, and none
  // shows the robot that it is on.
  std::array<Pose, kMostRobots> vehicle{};
  std::size_t vehicles = 0;
  bool rotors_turn = false;  // likewise: discs instead of blades
};

/// One figure about a run, with its limit.
struct Measure {
  const char* key = "";    // of the report and the summary: "landing_error_m"
  const char* label = "";  // for people: "landing error"
  const char* unit = "";
  double value = 0;
  std::optional<double> limit{};  // none: reported, not judged
  bool at_least = false;          // the limit is the least allowed value; else the most
};

/// How a run went; only its world knows. The runtime prints it, and its exit code follows `good`.
struct Verdict {
  std::string outcome;  // in words: "landed on the pad"
  bool good = false;
  bool begun = true;  // something happened that can be judged: a robot without a mission may also never begin
  std::vector<Measure> measures{};
  /// What the world did to the robot, against the most that the robot is meant for: "strongest wind". Not judged; a run
  /// that went wrong is explained by them.
  std::vector<Measure> conditions{};
};

/// For the report and for tests; no module ever sees it.
struct WorldTruth {
  msg::Vec3 p_world_m, v_world_mps;
  msg::Quat q_world_base;
  msg::Vec3 gyro_radps;      // base
  msg::Vec3 target_world_m;  // the pad, the ball
  double battery_v = 0;
  bool contact = false, landed = false;
};

/// One robot in a simulated world, as its side of a session sees it.
/// Thread:  the world's.
class SimRobot {
 public:
  virtual ~SimRobot() = default;
  /// What the step that just ended made available.
  virtual const Due& due() const = 0;
  virtual WorldTruth ground_truth() const = 0;
  /// What its camera with this number sees.
  virtual Scene scene(std::size_t camera) const = 0;
  /// No actuator drives anything, and nothing moves any more: a robot left alone may end.
  virtual bool still() const = 0;
  /// Counts events that a report should tell at once.
  virtual std::uint32_t news() const { return 0; }
  /// Adds the world's keys to the report: docs/sinew-sim.md.
  virtual void add_to(JsonObject& report) const = 0;
  /// How the run went, so far.
  virtual Verdict verdict() const = 0;
  /// The same with figures, in one line for people.
  virtual std::string outcome() const = 0;
  /// The joints of its actuator groups, one group after the other, for simulated drives; null: it has none.
  virtual PlantJoints* joints() { return nullptr; }
};

/// One setpoint per channel of a robot's actuator groups, one group after the other. Empty: all groups take their safe
/// action; NaN: the group of this channel does, while others have commands.
using RobotCommand = std::span<const double>;

/// Draws a world's scenes without MuJoCo's renderer and without OpenGL.
/// Thread:  one.
class Painter {
 public:
  virtual ~Painter() = default;
  /// Through the scene's camera; row after row from the top, a pixel is r | g << 8 | b << 16. Valid until the next
  /// call.
  virtual std::span<const std::uint32_t> draw(const Scene& scene) = 0;
};

/// A simulated world with its robots, without rendering, in steps of 0.25 ms. Same options and same commands give the
/// same bytes on every machine: nothing in it calls the C library's mathematics, which differ between CPUs.
/// Thread:  owner.
class World {
 public:
  virtual ~World() = default;
  /// Advances by 0.25 ms; `commands`: one for each robot.
  virtual void advance(std::span<const RobotCommand> commands) = 0;
  virtual msg::Time now() const = 0;
  virtual std::size_t robots() const = 0;
  virtual SimRobot& robot(std::size_t number) = 0;

  /// Advances a world of one robot; what that made available.
  const Due& step(RobotCommand command) {
    advance({&command, 1});
    return robot(0).due();
  }
};

/// A world that is its only robot.
class LoneRobot : public World, public SimRobot {
 public:
  std::size_t robots() const final { return 1; }
  SimRobot& robot(std::size_t /*number*/) final { return *this; }
};

/// The place of a viewer, and the point that it looks at.
struct Viewpoint {
  msg::Vec3 eye_m, target_m;
};

/// A picture of a world that shows what it is like: through the robot's camera, or from outside.
struct Portrait {
  std::string name;  // of the file
  Scene scene;
  std::optional<Viewpoint> outside{};  // none: through the camera
};

/// One kind of world. A robot's folder brings it (robots/), and nothing else knows it by name.
struct WorldType {
  WorldInfo info;
  std::string title;          // "a quadrotor in a room"
  std::string_view room_xml;  // MuJoCo's XML of what its camera sees, with one robot; empty: it has no camera
  /// The same where the world's values choose between several rooms; null: room_xml is the only one.
  std::function<std::string_view(const WorldValues&)> room_of = nullptr;
  /// What draws pictures of this size, where it is not MuJoCo's renderer; null: that draws room_xml.
  std::function<std::unique_ptr<Painter>(std::uint32_t width, std::uint32_t height, const WorldChoice& world)> painter =
      nullptr;
  /// With the robots of this choice, of this seed. Errors: those of its physics; bad_argument: two robots start in the
  /// same place.
  std::function<hal::Result<std::unique_ptr<World>>(const WorldChoice& choice, std::uint64_t seed)> create;
  /// Of the world with these values, and of its robots with their bodies.
  std::function<std::vector<Portrait>(const WorldChoice&)> portraits = [](const WorldChoice&) {
    return std::vector<Portrait>();
  };

  std::string_view room(const WorldValues& values) const { return room_of ? room_of(values) : room_xml; }
};

/// A robot of a world that has several.
struct NamedRobot {
  std::string name;                                // that its runtime says in Hello
  WorldValues values{};                            // of per_robot options, instead of those of the world
  std::shared_ptr<const kinematics::Body> body{};  // instead of that of the world
};

/// Which world a run is in.
struct WorldChoice {
  std::shared_ptr<const WorldType> type{};
  WorldValues values{};
  std::vector<NamedRobot> robots{};                // empty: one, of any name
  std::shared_ptr<const kinematics::Body> body{};  // of its robots, where the type has bodies

  std::size_t robot_count() const { return robots.empty() ? 1 : robots.size(); }
  /// The values of one robot.
  WorldValues values_of(std::size_t robot) const;
  /// The world as this robot has it.
  WorldInfo info_of(std::size_t robot) const;
  /// Of each robot, in their order.
  std::vector<WorldValues> all_values() const;
  /// Null: none was given.
  const kinematics::Body* body_of(std::size_t robot) const;
  hal::Result<std::unique_ptr<World>> create(std::uint64_t seed) const;
};

/// The seed of one robot's errors and draws: the first robot has the world's.
std::uint64_t seed_of_robot(std::uint64_t seed, std::size_t robot);

}  // namespace sinew::plant
