#pragma once
#include "math/random.hpp"
#include "robots/quad/world/rotors.hpp"
#include "sim_hil/mujoco/room.hpp"
#include "sim_hil/worlds/sensors.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

struct QuadOptions {
  std::uint64_t seed = 1;
  double gust_mps = 2.0;                                // wind never exceeds this, or wind_mps; 0: no gusts
  std::optional<double> wind_mps{}, wind_toward_rad{};  // its steady part; none: by the seed
  double spread = 0.05;                                 // of mass and of each motor's thrust, uniform
  double start_offset_m = 1.0;                          // at most this far from the pad
  double start_yaw_rad = 0.3;                           // at most, either way
  std::optional<double> start_x_m{}, start_y_m{}, start_heading_rad{};  // instead of what the seed says
  std::optional<double> battery_charge{};                               // 0..1, at the start; none: by the seed
  bool sensor_errors = true;                                            // false: sensors tell the truth
  double land_x_m = 0, land_y_m = 0;                                    // where it shall land; the pad's centre: 0, 0
  /// Where the vehicle is far from everything, its accelerations are those of a free body, without MuJoCo: the same but
  /// for rounding, in a quarter of the time. For learning; a world with one vehicle.
  bool free_flight = false;
  bool drag = true;  // false: with gust_mps 0, vacuum apart from the rotors
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
  bool on_pad = false;  // contact, and the base is above the pad, or as near to where it shall land
};

/// The flight as a whole.
struct FlightSummary {
  bool flew = false;          // was more than 0.1 m clear of the floor for half a second
  bool touched_down = false;  // first contact after having flown
  msg::Time touchdown_at;
  double touchdown_speed_mps = 0;  // downward, in the step before that contact
  double touchdown_drift_mps = 0;  // horizontal, likewise
  double touchdown_error_m = 0;    // base to where it shall land, horizontally, at that contact
  double max_height_m = 0;         // of the base
  double wind_max_mps = 0;
  bool crashed = false;  // touched anything with more than the feet, or another vehicle, or tilted over on the ground
};

/// One quadrotor of a QuadWorld: a free body of its model, with rotors, sensors and a look at how it flies.
/// Thread:  the world's.
class Quad final : public SimRobot {
 public:
  /// Number `number` of `all` vehicles in the model, which outlives this; errors and draws are of the options' seed.
  Quad(const QuadOptions& options, mjModel_& model, mjData_& data, std::size_t number,
       std::span<const Quad* const> all);
  /// Puts it where its options say, or else somewhere where none of the vehicles before it is. False: there is no room.
  bool start();

  const Due& due() const override { return due_; }
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override { return at_rest() && motors_stopped(); }
  std::uint32_t news() const override { return summary_.touched_down ? 1 : 0; }
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;

  TruthState truth() const;
  const FlightSummary& summary() const { return summary_; }
  CameraPose camera_pose() const;
  double mass_kg() const;
  const std::array<double, kRotors>& thrust_factor() const { return factor_; }
  /// Touches something and stands still (slower than 0.15 m/s and 2 rad/s).
  bool at_rest() const;
  bool motors_stopped() const;
  /// Base to where it shall land (the centre of the pad), horizontally, now: after the run, the landing error.
  double pad_distance_m() const;
  /// Puts the vehicle somewhere, at rest unless `v_world_mps` says otherwise; for tests and pictures.
  void place(const msg::Vec3& p_world_m, const msg::Quat& q_world_base, const msg::Vec3& v_world_mps = {});

  // What a step of the world consists of, in this order, with MuJoCo's accelerations between the first two.
  void apply_forces(RobotCommand command, const msg::Vec3& wind_world_mps);
  /// With QuadOptions::free_flight in place of MuJoCo's accelerations: false where something may be near.
  bool accelerate_freely();
  void integrate();
  void watch_contacts(msg::Time now);
  void sample(std::int64_t steps);

 private:
  msg::Vec3 position() const;
  msg::Vec3 velocity() const;
  msg::Vec3 rates() const;
  msg::Quat attitude() const;
  double distance_m(const msg::Vec3& p) const;
  double rotor_share() const;
  double true_range() const;
  int feet_down() const;
  bool touches() const;
  void spread_mass();

  QuadOptions options_;
  mjModel_& model_;
  mjData_& data_;
  std::size_t number_;
  std::span<const Quad* const> all_;
  math::Random noise_;
  std::array<double, kRotors> factor_;
  Propulsion propulsion_;
  ImuModel imu_;
  RangeModel range_;
  BaroModel baro_;
  BatteryModel battery_;
  int body_ = 0, hull_ = 0, first_foot_ = 0;
  msg::Time now_{};
  std::uint32_t next_frame_ = 1;
  int clear_steps_ = 0;
  msg::Vec3 v_before_, wind_;
  msg::Vec3 force_specific_;        // specific force of the last step, base
  msg::Vec3 gyro_sum_, accel_sum_;  // since the last IMU sample
  Due due_;
  FlightSummary summary_;
};

}  // namespace sinew::plant
