#pragma once
// An agent of SimSpark, without its socket: our body's angles to joint speeds, percepts to what our devices measure.
//
//   SparkAgent agent(map, body);
//   agent.take(text);                                 // of the server
//   agent.felt().joints_rad;                          // in the body's order and signs
//   agent.command(targets_rad, writer).sync();        // so that it is there at the end of the next cycle
//
// Thread:  owner.   RT: yes.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim_hil/pitch/stance.hpp"
#include "sim_hil/simspark/game.hpp"
#include "sim_hil/simspark/joints.hpp"
#include "wire/text/simspark.hpp"

namespace sinew::simspark {

/// Speed for a radian of error: joints follow as the servos do that our walk of this class of bodies was found with.
/// The fastest that a cycle allows, 50, shakes the body on its stiff motors.
inline constexpr double kFollow_per_s = 22;

/// What the body said last. Frames: torso, x ahead, y left, z up.
struct Felt {
  double now_s = 0;
  std::array<double, kinematics::kMaxLinks> joints_rad{}, joints_radps{};  // in the body's order; speeds by two cycles
  math::Vec3 gyro_radps, accel_mps2;
  std::array<std::array<double, 4>, 2> cell_n{};  // left, right: front left, front right, back left, back right
  std::uint64_t cycles = 0;
};

/// What the vision perceptor saw last, in the eye's frame, x ahead, y left, z up.
struct Sights {
  double at_s = -1;  // of the server's time; -1: never
  std::optional<math::Vec3> ball_m{};
  std::array<std::optional<math::Vec3>, 8> landmark_m{};  // in the order of kLandmarks
};

class SparkAgent {
 public:
  /// `body` lives as long.
  SparkAgent(const SparkJointMap& map, const kinematics::Body& body);

  /// One message of the server. Errors: that of the parser; then nothing of it is taken.
  wire::SparkError take(std::string_view text);
  const Felt& felt() const { return felt_; }
  const Sights& sights() const { return sights_; }
  /// Of the game: what the last message said.
  struct Said {
    std::string play_mode{}, side{};  // side empty: not yet known
    std::uint32_t number = 0;
    int left_goals = 0, right_goals = 0;
    double game_s = 0;
  };
  const Said& said() const { return said_; }

  /// Adds the speeds that draw all joints to these angles by kFollow_per_s of the rest, at most at the motors' speed.
  /// NaN: stand still, since SimSpark's motors have no torque off.
  wire::SparkWriter& command(std::span<const double> targets_rad, wire::SparkWriter& out) const;

 private:
  SparkJointMap map_;
  std::array<std::optional<plant::Sole>, 2> sole_{};
  wire::SparkPercepts percepts_{};
  Felt felt_;
  Sights sights_;
  Said said_;
};

/// Where a robot is on the field by the distances of landmarks, which do not depend on how its head is turned.
/// Source:  Gauss-Newton from `guess`. Errors: nothing with less than two landmarks, or when it does not converge.
std::optional<math::Vec3> place_of(const Sights& sights, double eye_height_m, const math::Vec3& guess_m);

}  // namespace sinew::simspark
