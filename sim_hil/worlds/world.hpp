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
#include "msg/sensors.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::plant {

class JsonObject;
class PlantJoints;

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
inline constexpr double kFocalPerHeight = 0.875;  // of each camera: fx = fy = 0.875 * height, 420 px at 640x480

enum class Part : std::uint8_t { imu, range, baro, camera, actuators, battery, joints };

/// As DriverKind::measures has it: "imu".
std::string_view to_string(Part part);

/// One device of a world.
struct WorldDevice {
  Part part{};
  const char* name = "";
  int steps = 0;              // plant steps from sample to sample; 0: at no fixed period
  std::int64_t delay_ns = 0;  // stamp to availability
  std::uint32_t channels = 0;
  FaultDevice fault{};
  double least = 0, most = 0;  // actuators: the sensible range of a command, in its unit
};

/// What a world has on board, each part at most once, in the order of the Welcome.
struct WorldInfo {
  const char* name = "";
  std::span<const WorldDevice> devices;

  /// Null when it has none.
  const WorldDevice* find(Part part) const;
  bool has(FaultDevice device) const;
};

/// The samples that the step that just ended made available. They carry their stamps; delays are not applied yet.
struct Due {
  bool imu = false, range = false, baro = false, battery = false, joints = false, camera = false, truth = false;
  msg::ImuSample imu_sample;
  msg::RangeSample range_sample;
  msg::BaroSample baro_sample;
  msg::BatterySample battery_sample;
  msg::JointState joints_sample;
};

/// The pose of a thing: its position, and the rotation that takes its coordinates to the world's.
struct Pose {
  msg::Vec3 p_world_m;
  msg::Quat q_world;
};

/// Pose of the camera.
struct CameraPose {
  msg::Vec3 p_world_m;
  msg::Quat q_world_optical;
};

/// All that a picture depends on: the camera, and the moving things in its sight, in the order of the room's mocap
/// bodies.
struct Scene {
  static constexpr std::size_t kMost = 6;
  CameraPose camera;
  std::array<Pose, kMost> body{};
  std::size_t bodies = 0;
  std::optional<Pose> vehicle{};  // for a room whose robot hangs on no joint; only pictures from outside show it
  bool rotors_turn = false;       // likewise: discs instead of blades
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

/// A simulated world, without rendering, in steps of 0.25 ms. Same options and same commands give the same bytes on
/// every machine: nothing in it calls the C library's mathematics, which differ between CPUs.
/// Thread:  owner.
class World {
 public:
  virtual ~World() = default;
  /// Advances by 0.25 ms. `command`: one setpoint per channel of the actuator group, or none: its safe action.
  virtual const Due& step(std::span<const double> command) = 0;
  virtual msg::Time now() const = 0;
  virtual WorldTruth ground_truth() const = 0;
  virtual Scene scene() const = 0;
  /// No actuator drives anything, and nothing moves any more: a world left alone may end.
  virtual bool still() const = 0;
  /// Counts events that a report should tell at once.
  virtual std::uint32_t news() const { return 0; }
  /// Adds the world's keys to the report: docs/sinew-sim.md.
  virtual void add_to(JsonObject& report) const = 0;
  /// How the run went, so far.
  virtual Verdict verdict() const = 0;
  /// The same with figures, in one line for people.
  virtual std::string outcome() const = 0;
  /// The joints of its actuator group, for simulated drives; null: it has none.
  virtual PlantJoints* joints() { return nullptr; }
};

/// A number that sinew-sim's command line gives to a world: --gust 3.
struct WorldOption {
  std::string name;  // "gust"
  std::string what;  // for --help; empty: of tests only
  double least = 0, most = 0, value = 0;
};
/// By the name of the option; options that are missing here have their own default.
using WorldValues = std::map<std::string, double, std::less<>>;

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
  std::string_view room_xml;  // MuJoCo's XML of what its camera sees; empty: it has no camera
  std::vector<WorldOption> options;
  /// Of this seed. Errors: those of its physics.
  std::function<hal::Result<std::unique_ptr<World>>(const WorldValues& values, std::uint64_t seed)> create;
  std::function<std::vector<Portrait>()> portraits = [] { return std::vector<Portrait>(); };

  /// The value of an option in `values`, or its own default.
  double value(const WorldValues& values, std::string_view option) const;
};

/// Which world a run is in.
struct WorldChoice {
  std::shared_ptr<const WorldType> type{};
  WorldValues values{};
};

}  // namespace sinew::plant
