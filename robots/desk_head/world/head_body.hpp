#pragma once
// The desk head's numbers, in one place; robots/desk_head/world/room.xml draws the same.
#include "math/linear.hpp"
#include "robots/desk_head/devices.hpp"

namespace sinew::plant {

/// Joints in every command and every state: 0 pan (about z of the base, positive to the left), 1 tilt (about y,
/// positive looks down).
/// Frames:  base: of the platform, x forward, y left, z up, origin in the pivot about which it rocks. yoke: turned by
///          pan, origin on the pan axis. head: turned by tilt, origin where both axes meet; x is the way it looks.
inline constexpr math::Vec3 kPivot{0, 0, 0.80};      // in the world: on the desk
inline constexpr math::Vec3 kPBaseYoke{0, 0, 0.12};  // yoke's origin in base
inline constexpr math::Vec3 kPYokeHead{0, 0, 0.08};  // head's origin in yoke
inline constexpr math::Vec3 kPHeadCamera{0.045, 0, 0.01}, kPHeadImu{0, 0, 0.03};
/// camera_optical: z forward (x of the head), x right (-y), y down (-z).
inline constexpr math::Quat kQHeadOptical{0.5, -0.5, 0.5, -0.5};

struct LinkInertia {
  double mass_kg = 0;
  math::Vec3 centre_m;      // of mass, in the link's frame
  math::Vec3 inertia_kgm2;  // about it, the link's axes
};
inline constexpr LinkInertia kYoke{0.15, {0, 0, 0.04}, {2.0e-4, 1.6e-4, 1.4e-4}};
inline constexpr LinkInertia kHead{0.25, {0.008, 0, 0.004}, {2.2e-4, 2.6e-4, 2.4e-4}};

inline constexpr double kBallRadius = 0.07, kPillarRadius = 0.10;

}  // namespace sinew::plant
