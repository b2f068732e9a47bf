#pragma once
#include <cstdint>
#include <memory>

#include "hal/result.hpp"
#include "msg/sensors.hpp"
#include "sim_hil/plant/sensors.hpp"
#include "sim_hil/plant/vehicle.hpp"

namespace sinew::plant {

inline constexpr std::int64_t kStepNs = 250'000;
inline constexpr int kImuSteps = 4, kTruthSteps = 40, kRangeSteps = 40, kBaroSteps = 80;  // 1 kHz, 100, 100, 50 Hz
inline constexpr int kBatterySteps = 400;                                                 // 10 Hz
inline constexpr std::int64_t kRangeDelayNs = 4'000'000, kBaroDelayNs = 2'000'000;        // stamp to availability
inline constexpr std::int64_t kBatteryDelayNs = 5'000'000;
inline constexpr int kCameraHz = 30;

struct WorldOptions {
  std::uint64_t seed = 1;
  double gust_mps = 2.0;        // wind never exceeds this; 0: still air
  double spread = 0.05;         // of mass and of each motor's thrust, uniform
  double start_offset_m = 1.0;  // at most this far from the pad
  double start_yaw_rad = 0.3;   // at most, either way
  bool sensor_errors = true;    // false: sensors tell the truth
  bool drag = true;             // false: with gust_mps 0, vacuum apart from the rotors
};

/// Where and how the vehicle is. Never shown to a module; for reports and tests.
struct TruthState {
  msg::Time stamp;
  msg::Vec3 p_world_m, v_world_mps;
  msg::Quat q_world_base;
  msg::Vec3 gyro_radps;  // base
  msg::Vec3 accel_mps2;  // specific force, base, mean of the last plant step
  msg::Vec3 wind_world_mps;
  std::array<double, kRotors> omega_radps{};
  double voltage_v = 0, current_a = 0, charge = 0;  // of the battery; charge 0..1
  bool contact = false;                             // something touches something
  int feet_down = 0;
  bool on_pad = false;  // contact, and the base is above the pad
};

/// The flight as a whole.
struct FlightSummary {
  bool flew = false;          // was more than 0.1 m clear of the floor for half a second
  bool touched_down = false;  // first contact after having flown
  msg::Time touchdown_at;
  double touchdown_speed_mps = 0;  // downward, in the step before that contact
  double touchdown_drift_mps = 0;  // horizontal, likewise
  double touchdown_error_m = 0;    // base to centre of the pad, horizontally, at that contact
  double max_height_m = 0;         // of the base
  bool crashed = false;            // touched anything with more than the feet, or tilted over on the ground
};

/// What the step that just ended has made available. Samples carry their stamps; the delays above are not applied yet.
struct Due {
  bool imu = false, range = false, baro = false, battery = false, camera = false, truth = false;
  msg::ImuSample imu_sample;
  msg::RangeSample range_sample;
  msg::BaroSample baro_sample;
  msg::BatterySample battery_sample;
};

/// Pose of the downward camera.
struct CameraPose {
  msg::Vec3 p_world_m;
  msg::Quat q_world_optical;
};

/// The simulated world, without rendering: a quadrotor in a room, in steps of 0.25 ms.
/// Same options and same commands give the same bytes on every machine: MuJoCo computes accelerations and contacts
/// with +, -, *, / and sqrt only; the state is integrated here, because its own integrator calls sin and cos of the C
/// library, which differ between CPUs.
/// Thread:  owner.
class World {
 public:
  static hal::Result<std::unique_ptr<World>> create(const WorldOptions& options);
  ~World();

  /// Advances by 0.25 ms with the motors commanded to `command` (order and unit: see vehicle.hpp).
  const Due& step(const std::array<double, kRotors>& command);

  msg::Time now() const;
  TruthState truth() const;
  const FlightSummary& summary() const;
  CameraPose camera_pose() const;
  double mass_kg() const;
  const std::array<double, kRotors>& thrust_factor() const;

  /// Puts the vehicle somewhere, at rest unless `v_world_mps` says otherwise; for tests and pictures.
  void place(const msg::Vec3& p_world_m, const msg::Quat& q_world_base, const msg::Vec3& v_world_mps = {});

 private:
  struct Impl;
  explicit World(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Stamp (mid-point of the exposure) of the frame with this number, counted from 1: multiples of 1/30 s on the grid of
/// the plant's steps.
constexpr std::int64_t camera_stamp_ns(std::uint32_t frame) {
  const std::int64_t exact = std::int64_t{frame} * 1'000'000'000 / kCameraHz;
  return (exact + kStepNs / 2) / kStepNs * kStepNs;
}

}  // namespace sinew::plant
