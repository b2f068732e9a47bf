#pragma once
// What SimSpark's vision perceptor sees: landmarks, ball, players and lines within 120 by 120 degrees, with its noise.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "kinematics/body.hpp"
#include "math/random.hpp"
#include "sim_hil/simspark/field.hpp"
#include "wire/text/simspark.hpp"

namespace sinew::simspark {

/// A player as others see it: its parts in the world.
struct SeenPlayer {
  std::string_view team;
  std::uint32_t number = 0;
  std::array<math::Vec3, 5> part_m{};  // in the order of kParts
};
inline constexpr std::array<std::string_view, 5> kParts{"head", "rlowerarm", "llowerarm", "rfoot", "lfoot"};

/// Source:  rcssserver3d, RestrictedVisionPerceptor: distances by 0.0965 % times a normal number, angles by 0.1225 and
///          0.1480 degrees, an offset of the eye of up to 5 mm along each axis, drawn once; nothing hides anything.
class SparkVision {
 public:
  explicit SparkVision(math::Random& random);

  /// Writes into the sightings of `out`. `eye` is in the world, x ahead, y left, z up. Texts live as long as `players`.
  void see(const kinematics::Pose& eye, const math::Vec3& ball_m, std::span<const SeenPlayer> players,
           math::Random& random, wire::SparkPercepts& out) const;

 private:
  math::Vec3 offset_m_;
};

/// Distance, azimuth and elevation of a point in the eye's frame.
wire::SparkPolar polar_of(const math::Vec3& in_eye_m);
/// And back.
math::Vec3 point_of(const wire::SparkPolar& polar);

}  // namespace sinew::simspark
