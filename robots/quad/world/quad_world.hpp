#pragma once
#include "robots/quad/devices.hpp"
#include "robots/quad/world/vehicle.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

struct QuadOptions {
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

/// A quadrotor in a room. MuJoCo computes accelerations and contacts with +, -, *, / and sqrt only; the state is
/// integrated here, because its own integrator calls sin and cos of the C library.
/// Thread:  owner.
class QuadWorld final : public World {
 public:
  static hal::Result<std::unique_ptr<QuadWorld>> create(const QuadOptions& options);
  ~QuadWorld() override;
  static WorldInfo info();

  /// Commands: order and unit as in vehicle.hpp; none: all 0.
  const Due& step(std::span<const double> command) override;
  msg::Time now() const override;
  WorldTruth ground_truth() const override;
  Scene scene() const override { return {camera_pose(), {}, 0}; }
  bool still() const override { return at_rest() && motors_stopped(); }
  std::uint32_t news() const override { return summary().touched_down ? 1 : 0; }
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;

  TruthState truth() const;
  const FlightSummary& summary() const;
  CameraPose camera_pose() const;
  double mass_kg() const;
  const std::array<double, kRotors>& thrust_factor() const;
  /// Touches something and stands still (slower than 0.15 m/s and 2 rad/s).
  bool at_rest() const;
  bool motors_stopped() const;
  /// Base to the centre of the pad, horizontally, now: after the run, the landing error.
  double pad_distance_m() const;

  /// Puts the vehicle somewhere, at rest unless `v_world_mps` says otherwise; for tests and pictures.
  void place(const msg::Vec3& p_world_m, const msg::Quat& q_world_base, const msg::Vec3& v_world_mps = {});

 private:
  struct Impl;
  explicit QuadWorld(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew::plant
