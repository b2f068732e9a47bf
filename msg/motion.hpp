#pragma once
// Motion that somebody outside of the loops asks for.
#include "msg/actuators.hpp"

namespace sinew::msg {

/// Velocity wanted of the whole robot, in its own axes.
struct VelocityCommand {
  Time stamp;
  Vec3 linear_mps;     // base: x forward, y left, z up
  Vec3 angular_radps;  // base: z is a turn to the left
};

inline constexpr std::size_t kMaxTrajectoryPoints = 16;

/// Where joints shall be, and when.
struct TrajectoryPoint {
  std::int64_t from_start_ns = 0;
  std::array<double, kMaxChannels> position_rad{};
  std::array<double, kMaxChannels> velocity_radps{};  // 0 where none was asked for
};

/// A motion of joints through points; times rise.
struct JointTrajectory {
  Time stamp;                // when it begins
  std::uint32_t count = 0;   // joints in use
  std::uint32_t points = 0;  // of `point` in use
  std::array<TrajectoryPoint, kMaxTrajectoryPoints> point{};
};

template <>
struct Description<VelocityCommand> {
  using M = VelocityCommand;
  static constexpr std::string_view name = "VelocityCommand", doc = "Velocity wanted of the whole robot.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::linear_mps>("m/s", "base"), field<&M::angular_radps>("rad/s", "base"));
};

template <>
struct Description<TrajectoryPoint> {
  using M = TrajectoryPoint;
  static constexpr std::string_view name = "TrajectoryPoint", doc = "Where joints shall be, and when.";
  static constexpr auto fields =
      describe(field<&M::from_start_ns>("ns", "after the trajectory's stamp"), field<&M::position_rad>("rad"),
               field<&M::velocity_radps>("rad/s", "0 where none was asked for"));
};

template <>
struct Description<JointTrajectory> {
  using M = JointTrajectory;
  static constexpr std::string_view name = "JointTrajectory", doc = "A motion of joints through points.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns", "when it begins"), field<&M::count>("1", "joints in use"),
               field<&M::points>("1", "of point in use"), field<&M::point>(""));
};

}  // namespace sinew::msg
